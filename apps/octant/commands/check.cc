// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/check.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/progress.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/text/layout.h"
#include "calib/statements/hints.h"
#include "io/site/site_yaml.h"
#include "io/text/json_values.h"

namespace octant::app {
namespace {

/// Results of the checks that precede the adjustment.
struct Logs {
  std::vector<calib::RunHealth> runs;
  std::vector<calib::Finding> findings;
  std::vector<bool> has_truth;  ///< truth.tum or truth.csv exists; it is not read
};

Logs examine(const Site& site, const std::vector<MeasurementLog>& runs) {
  Logs logs;
  logs.findings = calib::site_hints(site);
  for (const MeasurementLog& run : runs) {
    logs.runs.push_back(calib::log_health(site, run));
    const auto& found = logs.runs.back().findings;
    logs.findings.insert(logs.findings.end(), found.begin(), found.end());
    std::error_code ignored;
    const std::filesystem::path folder(run.path);
    logs.has_truth.push_back(std::filesystem::exists(folder / "truth.tum", ignored) ||
                             std::filesystem::exists(folder / "truth.csv", ignored));
  }
  for (auto& f : calib::silent_links(site, logs.runs)) logs.findings.push_back(std::move(f));
  return logs;
}

Json links_json(const std::vector<calib::LinkHealth>& links) {
  Json list = Json::array();
  for (const auto& l : links)
    list.push_back({{"id", l.name},
                    {"arrivals", l.arrivals},
                    {"rate_hz", l.rate_hz},
                    {"longest_silence_s", l.longest_silence_s}});
  return list;
}

Json coverage_json(const calib::Coverage& c) {
  return {{"rows", c.rows}, {"arrivals_covered", c.share}, {"longest_gap_s", c.longest_gap_s}};
}

Json run_json(const calib::RunHealth& h, bool has_truth) {
  Json gaps = Json::array(), steps = Json::array();
  for (const auto& g : h.gaps) gaps.push_back({{"from_s", g.from_s}, {"to_s", g.to_s}});
  for (const auto& s : h.clock_steps) steps.push_back({{"time_s", s.time_s}, {"step_s", s.step_s}});
  return {{"path", h.path},
          {"duration_s", h.duration_s},
          {"rows", h.rows},
          {"arrivals", h.arrivals},
          {"bearings", h.bearings},
          {"instants", h.instants},
          {"rejected", h.rejected},
          {"duplicates", h.duplicates},
          {"time_backwards", h.backwards},
          {"median_range_m", h.median_range_m},
          {"resolution_s", h.resolution_s > 0 ? Json(h.resolution_s) : Json(nullptr)},
          {"constant_beacons", h.constant},
          {"beacons", links_json(h.beacons)},
          {"receivers", links_json(h.receivers)},
          {"gaps", gaps},
          {"clock_steps", steps},
          {"temperature", {{"arrivals_with", h.temperature_share}, {"of_run", h.temperature_of_run}}},
          {"odometry", coverage_json(h.odometry)},
          {"poses", coverage_json(h.poses)},
          {"truth", has_truth}};
}

Json health_json(const Logs& logs) {
  Json runs = Json::array(), findings = Json::array();
  for (std::size_t i = 0; i < logs.runs.size(); ++i)
    runs.push_back(run_json(logs.runs[i], logs.has_truth[i]));
  for (const auto& f : logs.findings) findings.push_back({{"kind", f.kind}, {"text", f.text}});
  return {{"runs", runs}, {"findings", findings}};
}

Json forecast_verdict_json(const calib::Forecast& f) {
  const calib::Solution& s = f.solution;
  return {{"status", calib::to_string(s.status)},
          {"forecast", true},
          {"message", s.message},
          {"undetermined", s.undetermined},
          {"weak", weak_json(s.weak)},
          {"speed_mps", f.speed_mps > 0 ? Json(f.speed_mps) : Json(nullptr)},
          {"speed_sigma_mps", f.speed_sigma_mps},
          {"datum", s.datum.description},
          {"contradictions", io::json_of(s.contradictions)},
          {"arrivals", f.arrivals},
          {"arrivals_looked_at", f.arrivals_used},
          {"states", f.states},
          {"states_looked_at", f.states_used}};
}

Json beacons_json(const calib::Forecast& f) {
  Json list = Json::array();
  for (const auto& b : f.beacons)
    list.push_back({{"id", b.name},
                    {"status", to_string(b.status)},
                    {"arrivals", b.arrivals},
                    {"position_m", b.position_m},
                    {"sigma_m", b.sigma_m},
                    {"delay_sigma_s", b.delay_sigma_s}});
  return list;
}

std::string coverage_words(const calib::Coverage& c) {
  return c.rows == 0 ? "none"
                     : fmt::format("{} rows, with {:.0f} % of the arrivals, longest gap {:.3g} s", c.rows,
                                   100 * c.share, c.longest_gap_s);
}

std::string health_text(const calib::RunHealth& h, bool has_truth) {
  std::string text =
      fmt::format("{}: {:.4g} s, {} rows, {} arrivals at {} instants{}\n", h.path, h.duration_s, h.rows,
                  h.arrivals, h.instants, h.bearings > 0 ? fmt::format(", {} bearings", h.bearings) : "");
  for (const auto* links : {&h.beacons, &h.receivers}) {
    if (links == &h.receivers && links->size() < 2) continue;
    Table table{
        "lrrr",
        {{links == &h.beacons ? "beacon" : "receiver", "arrivals", "rate [Hz]", "longest silence [s]"}}};
    for (const auto& l : *links)
      table.rows.push_back(l.arrivals == 0
                               ? std::vector<std::string>{l.name, "0", "-", "-"}
                               : std::vector<std::string>{l.name, fmt::format("{}", l.arrivals),
                                                          fmt::format("{:.3g}", l.rate_hz),
                                                          fmt::format("{:.1f}", l.longest_silence_s)});
    text += "\n" + table.text();
  }
  const std::string rejected = counts_in_words(h.rejected);
  text += "\n";
  text += named_line("rejected rows", rejected.empty() ? "none" : rejected);
  text += named_line("duplicate rows", fmt::format("{}", h.duplicates));
  text += named_line("pauses", h.gaps.empty() ? "none"
                                              : fmt::format("{}, the longest {:.3g} s", h.gaps.size(),
                                                            h.gaps[0].to_s - h.gaps[0].from_s));
  text += named_line("clock jumps",
                     h.clock_steps.empty() ? "none seen" : fmt::format("{}", h.clock_steps.size()));
  text += named_line("median range", length_text(h.median_range_m));
  if (h.resolution_s > 0) text += named_line("resolution", time_text(h.resolution_s));
  text += named_line("temperature", h.temperature_share > 0 ? fmt::format("with {:.0f} % of the arrivals",
                                                                          100 * h.temperature_share)
                                    : h.temperature_of_run  ? "of the run"
                                                            : "of the site only");
  text += named_line("odometry", coverage_words(h.odometry));
  text += named_line("measured poses", coverage_words(h.poses));
  text += named_line("truth.tum", has_truth ? "present (not opened)" : "none");
  return text + "\n";
}

std::string state_in_words(const calib::BeaconForecast& b) {
  switch (b.status) {
    case BeaconStatus::kControlPoint: return "control point";
    case BeaconStatus::kUndetermined: return "undetermined";
    default: return "";
  }
}

std::string check_beacon_table(const calib::Forecast& f) {
  double largest_m = 0.0, largest_delay_s = 0.0;
  for (const auto& b : f.beacons) {
    if (b.sigma_m && b.status != BeaconStatus::kUndetermined)
      largest_m = std::max(largest_m, b.sigma_m->maxCoeff());
    largest_delay_s = std::max(largest_delay_s, b.delay_sigma_s);
  }
  const Unit length = length_unit(largest_m), time = time_unit(largest_delay_s);
  Table table{"lrrrrrl",
              {{"beacon", "arrivals", fmt::format("sx [{}]", length.name), "sy", "sz",
                largest_delay_s > 0 ? fmt::format("s delay [{}]", time.name) : "", ""}}};
  for (const auto& b : f.beacons) {
    std::vector<std::string> row = {b.name, fmt::format("{}", b.arrivals)};
    for (int i = 0; i < 3; ++i)
      row.push_back(b.status == BeaconStatus::kControlPoint ? "fixed"
                    : b.sigma_m ? fmt::format("{:.2f}", length.per_si * (*b.sigma_m)[i])
                                : "-");
    row.push_back(largest_delay_s > 0 ? fmt::format("{:.3f}", time.per_si * b.delay_sigma_s) : "");
    row.push_back(state_in_words(b));
    table.rows.push_back(std::move(row));
  }
  return table.text();
}

/// Undetermined beacons that do not block the others, one line for each remedy. The table shows their
/// accuracy.
std::string lone_beacons_text(const calib::Solution& s) {
  std::vector<std::pair<std::string, std::vector<const calib::WeakDirection*>>> by_remedy;
  for (const auto& w : s.weak) {
    if (!w.lone_beacon) continue;
    auto at = std::ranges::find_if(by_remedy, [&](const auto& r) { return r.first == w.remedy; });
    if (at == by_remedy.end()) at = by_remedy.insert(at, {w.remedy, {}});
    at->second.push_back(&w);
  }
  std::string text;
  for (const auto& [remedy, beacons] : by_remedy) {
    std::string who = beacons.front()->description;
    if (beacons.size() > 1) {
      std::vector<std::string> names;
      for (const auto* w : beacons)
        names.push_back(w->parameters.front().substr(std::string_view("beacon/").size()));
      who = fmt::format("beacons {}", fmt::join(names, ", "));
    }
    text += named_line("weak", fmt::format("{}; remedy: {}", who, remedy));
  }
  return text;
}

/// The main result: can these data determine the parameters, and if not, which measurement would?
std::string forecast_verdict_text(const calib::Forecast& f) {
  const calib::Solution& s = f.solution;
  const bool converged = s.status == calib::SolveStatus::kConverged;
  const bool refused = s.status == calib::SolveStatus::kUndetermined;
  const char* verdict = !s.contradictions.empty() && refused
                            ? "the data do not fit what was stated, as the warnings say: calibrate would "
                              "refuse (exit 5)"
                        : !s.contradictions.empty()
                            ? "the data contradict what was stated, as the warnings say: calibrate would "
                              "end with exit 6"
                        : converged && !s.undetermined.empty()
                            ? "these data can determine the rest, but not what is listed as weak"
                        : converged ? "these data can determine what the site asks for"
                        : refused
                            ? "these data cannot determine what the site asks for: calibrate would refuse"
                            : "the adjustment did not converge: calibrate may not either";
  std::string text;
  text += named_line("verdict", verdict);
  for (const auto& w : s.weak) {
    if (w.lone_beacon) continue;
    const std::string at_robot = w.consequence_m > 0 && std::isfinite(w.consequence_m)
                                     ? fmt::format(": up to {} at the robot", length_text(w.consequence_m))
                                     : "";
    text += named_line(w.blocking ? "undetermined" : "weak",
                       fmt::format("{}{}; remedy: {}", w.description, at_robot, w.remedy));
  }
  return text + lone_beacons_text(s);
}

std::string forecast_tables(const calib::Forecast& f, const std::string& site) {
  const std::string from =
      f.is_subsampled() ? fmt::format("a quick adjustment of {} of the {} arrivals, scaled to all of them",
                                      f.arrivals_used, f.arrivals)
                        : fmt::format("an adjustment of all {} arrivals", f.arrivals);
  std::string text =
      paragraph(fmt::format("{}: what a calibration would find (a forecast: sigmas predicted from {})",
                            site.empty() ? "site without a name" : site, from));
  if (f.solution.beacon_status.empty()) return text;
  text += "\n" + check_beacon_table(f) + "\n";
  if (f.speed_sigma_mps)
    text += named_line("speed", *f.speed_sigma_mps > 0 ? fmt::format("{:.2f} m/s, predicted sigma {:.2g} m/s",
                                                                     f.speed_mps, *f.speed_sigma_mps)
                                                       : fmt::format("{:.2f} m/s, held fixed", f.speed_mps));
  text += named_line("datum", f.solution.datum.description);
  return text;
}

calib::Forecast forecast(const calib::Problem& problem, bool strict, Session& session) {
  ProgressReporter reporter(progress_style(session.options.progress, session.options.quiet));
  calib::SolveOptions options = solve_options(session, reporter);
  options.strict = strict;
  return calib::forecast(problem, options);
}

/// Findings of the quick adjustment: contradictions, or suspicious observations if there are none.
std::vector<calib::Finding> findings_of(const calib::Forecast& f, Logs& logs) {
  std::vector<calib::Finding> findings;
  for (const Contradiction& c : f.solution.contradictions)
    findings.push_back({to_string(c.kind), in_words(c) + "; " + c.remedy});
  return findings.empty() ? calib::suspicions(f, logs.runs) : findings;
}

void warn_of(const std::vector<calib::Finding>& findings, Session& session) {
  for (const auto& f : findings) session.warn(f.text);
}

}  // namespace

int check_recordings(Site site, std::vector<MeasurementLog> runs, bool strict, Session& session) {
  Logs logs = examine(site, runs);
  warn_of(logs.findings, session);
  const std::string name = site.name;
  auto problem = calib::make_problem(std::move(site), std::move(runs), session.threads());
  if (!problem) {
    for (std::size_t i = 0; i < logs.runs.size(); ++i)
      session.result(health_text(logs.runs[i], logs.has_truth[i]));
    // Logs from which no problem can be built (wrong unit, no vehicle states) are still reported.
    return session.fail(failure_of(problem.error()),
                        {{"health", health_json(logs)}, {"verdict", nullptr}, {"beacons", Json::array()}});
  }
  const calib::Forecast f = forecast(*problem, strict, session);
  stop_if_interrupted(f.solution.status == calib::SolveStatus::kInterrupted);
  const auto suspected = findings_of(f, logs);
  warn_of(suspected, session);
  logs.findings.insert(logs.findings.end(), suspected.begin(), suspected.end());
  session.warn(f.solution.warnings);

  session.result(forecast_verdict_text(f) + "\n");
  for (std::size_t i = 0; i < logs.runs.size(); ++i)
    session.result(health_text(logs.runs[i], logs.has_truth[i]));
  session.result(forecast_tables(f, name));
  const Json object = {{"health", health_json(logs)},
                       {"verdict", forecast_verdict_json(f)},
                       {"beacons", beacons_json(f)},
                       {"seconds", session.seconds()}};
  if (f.solution.status == calib::SolveStatus::kUndetermined)
    return session.fail({"undetermined", "undetermined", kUndetermined, f.solution.message, ""}, object);
  if (f.solution.status == calib::SolveStatus::kNotConverged)
    return session.fail({"not_converged", "not_converged", kNotConverged, f.solution.message,
                         "are the units, the beacon ids and the approximate positions right?"},
                        object);
  return session.finish(object);
}

int check_recordings(const CheckArgs& args, Session& session) {
  Site site = need(io::read_site(args.site));
  session.warn(site.warnings);
  std::vector<MeasurementLog> runs = read_runs(args.runs, site, {}, session);
  return check_recordings(std::move(site), std::move(runs), args.strict, session);
}

void add_check(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<CheckArgs>(
      app, common, action, "check",
      "Tell what recordings are worth: their health, and what they can and cannot determine",
      "octant check hall/site.yaml hall/run", check_recordings);
  add_required_option(*command, "site", args->site, "SITE.yaml", "Site file: what is known beforehand");
  add_required_option(*command, "run", args->runs, "RUN", "Run folders: the recordings");
  command->add_flag("--strict", args->strict, "A single undetermined beacon is exit 5");
}

}  // namespace octant::app
