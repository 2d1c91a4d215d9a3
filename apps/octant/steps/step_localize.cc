// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/text/layout.h"
#include "io/deployment/deployment_json.h"
#include "io/deployment/signature.h"
#include "io/text/bounds.h"
#include "models/changes/chi_square.h"
#include "models/localizers/common/open_attitude.h"
#include "survey/latency.h"

namespace octant::app {

Result<Deployment> read_trusted_deployment(const std::string& path, const std::string& trusted_key) {
  if (trusted_key.empty()) return io::read_deployment(path);
  // Reads the file only once, so that the verified content is the content in use.
  const auto text = io::read_document(path);
  if (!text) return fail(text.error());
  if (auto genuine = io::check_signature(*text, path, trusted_key); !genuine) return fail(genuine.error());
  return io::deployment_from_json(*text, path);
}

void warn_of_repeated_runs(const std::vector<std::string>& folders, Session& session) {
  for (std::size_t i = 0; i < folders.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      std::error_code missing;
      if (!std::filesystem::equivalent(folders[i], folders[j], missing)) continue;
      session.warn(fmt::format("{} is named twice: what was heard there counts twice", folders[i]));
      break;
    }
}

std::vector<MeasurementLog> read_runs(const std::vector<std::string>& folders, const NameTable& names,
                                      const Timing& timing, io::ReadRunOptions options, Session& session) {
  const ExitAtOnce nothing_written_yet;
  options.threads = session.threads();
  warn_of_repeated_runs(folders, session);
  std::vector<MeasurementLog> runs;
  for (const auto& folder : folders) {
    const MeasurementLog& run = runs.emplace_back(need(io::read_run(folder, names, timing, options)));
    session.warn(run.warnings);
    session.detail(fmt::format("{}: {} arrivals, {} rows that are none, {} odometry rows, {} measured poses",
                               folder, run.arrivals.size(), run.rejected.size(), run.odometry.size(),
                               run.poses.size()));
  }
  return runs;
}

BeaconFlights read_beacon_flights(const std::vector<std::string>& folders, const NameTable& names,
                                  Session& session) {
  BeaconFlights all;
  for (std::size_t run = 0; run < folders.size(); ++run) {
    const io::BeaconFlightLog log = need(io::read_beacon_flights(folders[run], names, run));
    session.warn(log.warnings);
    all.flights.insert(all.flights.end(), log.flights.begin(), log.flights.end());
    if (!log.file.empty()) all.inputs.push_back({log.file, log.sha256});
  }
  return all;
}

void Localization::add_run(std::vector<Fix> fixes_of_run) {
  if (fixes.empty()) {  // for a single long drive they need most of the memory
    fixes = std::move(fixes_of_run);
  } else {
    fixes.insert(fixes.end(), std::make_move_iterator(fixes_of_run.begin()),
                 std::make_move_iterator(fixes_of_run.end()));
  }
  run_ends.push_back(fixes.size());
}

std::span<const Fix> Localization::of_run(std::size_t run) const {
  const std::size_t first = run == 0 ? 0 : run_ends[run - 1];
  return std::span(fixes).subspan(first, run_ends[run] - first);
}

namespace {

std::optional<RunSpeed> speed_of(const Deployment& deployment, const MeasurementLog& run, Method method) {
  if (method != Method::kLeastSquares && method != Method::kTracker) return std::nullopt;
  if (!speed_is_unknown(deployment, run)) return std::nullopt;
  return estimate_run_speed(deployment, run);
}

}  // namespace

Result<Localization> localize_runs(const Deployment& deployment, const std::vector<MeasurementLog>& runs,
                                   Method wanted, const MethodInput& input) {
  Localization result;
  for (const auto& run : runs) {
    const MethodChoice choice =
        wanted == Method::kAuto ? choose_method(deployment, run, input) : MethodChoice{wanted, ""};
    {
      const ExitAtOnce nothing_written_yet;
      result.speeds.push_back(speed_of(deployment, run, choice.method));
      const auto& speed = result.speeds.back();
      auto fixes = speed && speed->differs()
                       ? locate_run(choice.method, at_speed(deployment, *speed), run, input)
                       : locate_run(choice.method, deployment, run, input);
      if (!fixes) {
        Error error = fixes.error();
        error.code = Errc::kBadInput;
        if (error.file.empty()) error.file = run.path;
        const std::string name = to_string(choice.method);
        error.found = error.found.rfind(name, 0) == 0 ? "method " + error.found
                                                      : fmt::format("method {}: {}", name, error.found);
        return fail(std::move(error));
      }
      result.add_run(std::move(*fixes));
    }
    const std::string name = to_string(choice.method);
    if (result.method.find(name) == std::string::npos) {
      result.method += (result.method.empty() ? "" : "+") + name;
      if (wanted == Method::kAuto)
        result.why += fmt::format("{}{}", result.why.empty() ? "" : "; ", choice.why);
      if (const std::string why = why_no_level(choice.method); !why.empty())
        result.no_levels += fmt::format("{}{}: {}", result.no_levels.empty() ? "" : "; ", name, why);
    }
    result.rejected += run.rejected.size();
    for (const Fix& fix : result.of_run(result.run_ends.size() - 1)) {
      ++(fix.ok() ? result.ok : result.no_fix);
      if (!fix.ok()) ++result.no_fix_reasons[to_string(fix.status)];
      if (integrity(fix) == Integrity::kDegraded) ++result.degraded_reasons[integrity_reason(fix)];
      result.arrivals += static_cast<std::size_t>(std::max(0, fix.arrivals_used));
      result.rejected += static_cast<std::size_t>(std::max(0, fix.arrivals_rejected));
    }
  }
  return result;
}

std::size_t Localization::degraded() const {
  std::size_t sum = 0;
  for (const auto& [reason, count] : degraded_reasons) sum += count;
  return sum;
}

std::string integrity_text(const Localization& localization) {
  std::string text =
      fmt::format("{} ok, {} degraded", localization.ok - localization.degraded(), localization.degraded());
  if (!localization.degraded_reasons.empty()) text += ": " + counts_in_words(localization.degraded_reasons);
  if (!localization.no_levels.empty())
    text += fmt::format("; no protection levels: {}", localization.no_levels);
  return named_line("integrity", text);
}

Json integrity_json(const Localization& localization) {
  Json object = {{"ok", localization.ok - localization.degraded()},
                 {"degraded", localization.degraded()},
                 {"no_fix", localization.no_fix},
                 {"degraded_reasons", localization.degraded_reasons}};
  if (!localization.no_levels.empty()) object["no_levels"] = localization.no_levels;
  return object;
}

void check_truth(const std::vector<MeasurementLog>& runs) {
  for (const MeasurementLog& run : runs)
    if (run.truth.empty())
      fail_with({.code = Errc::kBadInput,
                 .file = run.path + "/truth.tum",
                 .found = "there is no reference trajectory",
                 .expected = "a file truth.tum with at least one pose, or truth.csv with at least one point",
                 .advice = "verify needs a run whose true poses are known; whether the calibration still "
                           "holds, octant monitor tells without them"});
}

survey::Evaluation verify_fixes(const Deployment& deployment, const std::vector<MeasurementLog>& runs,
                                const Localization& localization) {
  check_truth(runs);
  std::vector<survey::ReferencedRun> referenced;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    survey::ReferencedRun run{{}, runs[i].truth, runs[i].truth_accuracy, runs[i].path};
    run.p_located_vehicle_m = receiver_centre_m(deployment, runs[i].vehicle);
    // truth.tum follows one vehicle; the others of the run have no reference.
    const std::span<const Fix> fixes = localization.of_run(i);
    std::ranges::copy_if(fixes, std::back_inserter(run.fixes), [&](const Fix& fix) {
      return !runs[i].vehicle.valid() || !fix.vehicle.valid() || fix.vehicle == runs[i].vehicle;
    });
    run.latencies_s = survey::latencies_s(run.fixes, runs[i]);
    referenced.push_back(std::move(run));
  }
  return survey::evaluate(referenced, deployment.motion, deployment.tolerance);
}

Json gates_json(const std::vector<survey::Gate>& gates) {
  Json list = Json::array();
  for (const survey::Gate& gate : gates)
    list.push_back({{"name", gate.name}, {"limit", gate.limit}, {"value", gate.value}, {"pass", gate.pass}});
  return list;
}

namespace {

Json errors_json(const survey::ErrorFigures& figures, bool any) {
  const auto figure = [any](double value) { return any ? Json(value) : Json(nullptr); };
  return {{"mean_error_m", figure(figures.mean_m)},
          {"ce50_m", figure(figures.ce50_m)},
          {"ce95_m", figure(figures.ce95_m)},
          {"ve95_m", figures.ve95_m},
          {"se95_m", figures.se95_m}};
}

/// A row for each recording or floor.
std::string runs_text(const std::vector<survey::RunFigures>& runs, const char* subject) {
  Table table{"lrrrrrrrr",
              {{subject, "fixes", "available", "covered", "mean", "RMSE", "CE95", "VE95", "SE95"}}};
  for (const survey::RunFigures& run : runs) {
    const auto length = [&run](const std::optional<double>& value_m) {
      return run.matched > 0 && value_m ? length_text(*value_m) : std::string("-");
    };
    const survey::ErrorFigures& e = run.errors;
    table.rows.push_back({run.name, fmt::format("{}", run.fixes),
                          fmt::format("{:.1f} %", 100 * run.availability),
                          fmt::format("{:.1f} %", 100 * run.coverage), length(e.mean_m), length(e.rmse_m),
                          length(e.ce95_m), length(e.ve95_m), length(e.se95_m)});
  }
  return table.text();
}

Json runs_json(const std::vector<survey::RunFigures>& runs, const char* subject) {
  Json rows = Json::array();
  for (const survey::RunFigures& run : runs) {
    Json row = errors_json(run.errors, run.matched > 0);
    row.update({{subject, run.name},
                {"fixes", run.fixes},
                {"no_fix", run.no_fix},
                {"matched", run.matched},
                {"rmse_m", run.matched > 0 ? Json(run.errors.rmse_m) : Json(nullptr)},
                {"availability", run.availability},
                {"coverage", run.coverage}});
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Json evaluation_json(const survey::Evaluation& e) {
  const auto figure = [&](double value) { return e.matched > 0 ? Json(value) : Json(nullptr); };
  Json object = errors_json(e.errors, e.matched > 0);
  object.update({{"fixes", e.fixes},
                 {"no_fix", e.no_fix},
                 {"availability", e.availability},
                 {"coverage", e.coverage},
                 {"latency_s", e.latency ? Json(e.latency->mean_s) : Json(nullptr)},
                 {"latency_p95_s", e.latency ? Json(e.latency->p95_s) : Json(nullptr)},
                 {"latency_max_s", e.latency ? Json(e.latency->largest_s) : Json(nullptr)},
                 {"runs", runs_json(e.runs, "run")},
                 {"floors", runs_json(e.floors, "floor")},
                 {"matched", e.matched},
                 {"position_rmse_m", figure(e.position_rmse_m)},
                 {"position_p95_m", figure(e.position_p95_m)},
                 {"heading_rmse_rad", e.heading_rmse_rad},
                 {"max_error_m", figure(e.max_error_m)},
                 {"nees_mean", e.nees_mean},
                 {"gates", gates_json(e.gates)}});
  return object;
}

std::vector<std::string> runs_of_calibration(const Deployment& deployment,
                                             const std::vector<MeasurementLog>& runs) {
  std::set<std::string> calibrated;
  for (const InputDigest& input : deployment.inputs) calibrated.insert(input.sha256);
  const auto is_data = [](const std::string& path) {
    const std::string name = std::filesystem::path(path).filename().string();
    return name == "tof.csv" || name == "bearings.csv" || name == "scans.csv";
  };
  std::vector<std::string> same;
  for (const MeasurementLog& run : runs)
    if (std::ranges::any_of(run.sha256, [&](const auto& file) {
          return is_data(file.first) && calibrated.contains(file.second);
        }))
      same.push_back(run.path);
  return same;
}

std::string doubt_of_sigmas(const survey::Evaluation& e, Motion motion) {
  constexpr double kByChance = 1e-3;
  if (!e.nees_mean) return "";
  const bool planar = motion == Motion::kPlanar;
  const int freedom = e.heading_rmse_rad ? (planar ? 3 : 6) : (planar ? 2 : 3);
  const double limit = chi_square_beyond(kByChance, freedom) / freedom;
  if (*e.nees_mean <= limit) return "";
  const std::string heading = e.heading_rmse_rad
                                  ? fmt::format(", headings by {:.3g} rad ({:.3g} degrees)",
                                                *e.heading_rmse_rad, *e.heading_rmse_rad * 180.0 / M_PI)
                                  : "";
  return fmt::format(
      "the stated sigmas of the fixes do not hold: NEES {:.3g}, where 1 is expected and chance alone stays "
      "below {:.1f}; positions are off by {} RMS{}: do truth and map share the frame and the units, and are "
      "the receivers where the deployment has them?",
      *e.nees_mean, limit, length_text(e.position_rmse_m), heading);
}

std::string why_no_fix(const Localization& localization) {
  static const std::map<std::string, const char*> words = {
      {to_string(FixStatus::kTooFewArrivals),
       "too few beacons were received at a time. In the plane a fix takes two or three ranges, in space "
       "three or four"},
      {to_string(FixStatus::kPoorGeometry),
       "the geometry leaves a direction of the position undetermined, such as a turn about beacons that are "
       "nearly in line. Add a beacon off that line, or measure the height"},
      {to_string(FixStatus::kAmbiguous),
       "two positions explain the arrivals equally well, such as mirror images in the plane of the beacons. "
       "Add a beacon off that plane, or send odometry"},
      {to_string(FixStatus::kNoConsensus),
       "the arrivals contradict each other at every position. Check that the deployment is that of the "
       "run's site, and the units of tof_s"},
      {to_string(FixStatus::kNotConverged), "the adjustment did not converge"}};
  const auto most = std::ranges::max_element(localization.no_fix_reasons, {},
                                             [](const auto& reason) { return reason.second; });
  if (most == localization.no_fix_reasons.end()) return "no arrival of a known beacon was received";
  const auto sentence = words.find(most->first);
  return fmt::format("in {} of {} epochs or instants {}", most->second, localization.no_fix,
                     sentence == words.end() ? "there is no position" : sentence->second);
}

Json no_fix_json(const Localization& localization) { return Json(localization.no_fix_reasons); }

std::string unmatched_text(const Localization& localization) {
  if (localization.ok > 0)
    return fmt::format(
        "none of the {} fixes has a reference at its time (poses of truth.tum at most 1 s apart around it, "
        "or truth.csv with its epoch)",
        localization.ok);
  return fmt::format("there is no fix to compare with the reference: {} (method {})",
                     why_no_fix(localization), localization.method);
}

std::string evaluation_text(const survey::Evaluation& e, const Localization& localization) {
  std::string text;
  const auto line = [&](const char* name, const std::string& what) { text += named_line(name, what); };
  line("fixes",
       fmt::format("{}, {} of them with a reference; {} times no fix", e.fixes, e.matched, e.no_fix));
  if (e.matched > 0) {
    line("position error", fmt::format("mean {}, RMSE {}, 95 % {}, largest {}", length_text(e.errors.mean_m),
                                       length_text(e.position_rmse_m), length_text(e.position_p95_m),
                                       length_text(e.max_error_m)));
    const auto in_space = [](const char* name, const std::optional<double>& value_m) {
      return value_m ? fmt::format(", {} {}", name, length_text(*value_m)) : std::string();
    };
    line("ISO/IEC 18305",
         fmt::format("CE50 {}, CE95 {}{}{}", length_text(e.errors.ce50_m), length_text(e.errors.ce95_m),
                     in_space("VE95", e.errors.ve95_m), in_space("SE95", e.errors.se95_m)));
    line("availability", fmt::format("{:.1f} % of the epochs, coverage {:.1f} % of the reference",
                                     100 * e.availability, 100 * e.coverage));
  }
  if (e.latency)
    line("latency", fmt::format("mean {:.3g} s, 95 % {:.3g} s, largest {:.3g} s", e.latency->mean_s,
                                e.latency->p95_s, e.latency->largest_s));
  if (e.heading_rmse_rad) line("heading error", fmt::format("RMSE {:.4f} rad", *e.heading_rmse_rad));
  if (e.nees_mean)
    line("NEES", fmt::format("{:.2f} of its degrees of freedom (1: stated sigmas are honest)", *e.nees_mean));
  for (const auto& gate : e.gates) {
    if (gate.name == "matched") {
      line("gate matched", "NOT KEPT: " + unmatched_text(localization));
    } else {
      line(("gate " + gate.name).c_str(), fmt::format("{}: {}, limit {}", gate.pass ? "kept" : "NOT KEPT",
                                                      length_text(gate.value), length_text(gate.limit)));
    }
  }
  if (e.gates.empty()) line("gates", "none: the site states no tolerance for fixes");
  if (e.runs.size() > 1) text += runs_text(e.runs, "run");
  if (!e.floors.empty()) text += runs_text(e.floors, "floor");
  return text;
}

}  // namespace octant::app
