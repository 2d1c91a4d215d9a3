// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/steps/revisiting.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/options.h"
#include "apps/octant/progress.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/text/changes_text.h"
#include "apps/octant/text/layout.h"
#include "apps/octant/text/validity_words.h"
#include "io/deployment/deployment_json.h"

namespace octant::app {
namespace {

/// The test of a beacon's or receiver's own change that chance explains least.
struct LeastLikely {
  double p = 1.0;
  std::string what;
};

LeastLikely least_likely(const calib::Revisit& r, std::size_t owner, bool receiver) {
  LeastLikely out;
  for (const TestedChange& t : r.comparison.search.tested) {
    const ChangeHypothesis& h = r.comparison.hypotheses[t.hypothesis];
    if (h.kind == ChangeKind::kSpeed || (h.kind == ChangeKind::kReceiver) != receiver || h.owner != owner)
      continue;
    if (out.what.empty() || t.p < out.p) out = {t.p, to_string(h.kind)};
  }
  return out;
}

Json heard_json(const calib::Heard& h, const LeastLikely& test) {
  return {{"id", h.name},           {"used", h.used},    {"late", h.late}, {"early", h.early},
          {"misfit_s", h.misfit_s}, {"test", test.what}, {"p", test.p}};
}

std::vector<std::string> heard_row(const calib::Heard& h, const LeastLikely& test) {
  return {h.name,
          fmt::format("{}", h.used),
          fmt::format("{}", h.late),
          fmt::format("{}", h.early),
          h.used + h.late + h.early > 0 ? fmt::format("{:+.1f}", 1e6 * h.misfit_s) : "-",
          test.p < 1 ? fmt::format("{:.2g}", test.p) : "1"};
}

std::string medium_text(const SecondVisitFiles& visit) {
  const calib::MediumFound& m = visit.revisit.medium;
  constexpr double kPerDegree_mps = 0.606;
  if (!m.temperature_known) {
    const double warmer = m.speed_change_mps / kPerDegree_mps,
                 sigma = m.speed_change_sigma_mps / kPerDegree_mps;
    return named_line(
        "medium", fmt::format("no thermometer; by its speed the air is {:.1f} degC {} than {:.1f} degC "
                              "(sigma {:.1f} degC)",
                              std::abs(warmer), warmer > 0 ? "warmer" : "colder", m.temperature_degC, sigma));
  }
  std::string text =
      fmt::format("speed {:+.2f} m/s (sigma {:.2f} m/s) against the calibration, at {:.1f} degC",
                  m.speed_change_mps, m.speed_change_sigma_mps, m.temperature_degC);
  if (const auto& range = visit.before.validity_temperature_degC) {
    const double above = m.temperature_degC - (*range)[1], below = (*range)[0] - m.temperature_degC;
    if (std::max(above, below) >= 1.0)
      text += fmt::format(": the air is {:.0f} degC {} than the calibration knew", std::max(above, below),
                          above > below ? "warmer" : "colder");
  }
  return named_line("medium", text);
}

}  // namespace

void add_drift_options(CLI::App& command, DriftArgs& args) {
  const OptionGroup group(
      command,
      "Drift since the earlier calibration (standard deviations; by default by the time that passed)");
  add_option(command, "--drift-beacon-m", args.beacon_m, "M",
             "Of each coordinate of a beacon; 0.001 and 0.0001 a month")
      ->check(CLI::PositiveNumber);
  add_option(command, "--drift-delay-s", args.delay_s, "S", "Of a delay; 3e-6 and 3e-7 a month")
      ->check(CLI::PositiveNumber);
  add_option(command, "--drift-receiver-m", args.receiver_m, "M",
             "Of each coordinate of a receiver; 0.0005 and 0.00005 a month")
      ->check(CLI::PositiveNumber);
  add_option(command, "--drift-speed-mps", args.speed_mps, "V",
             "Of the speed at the same temperature; 0.3 and 0.03 a month")
      ->check(CLI::PositiveNumber);
}

Drift drift_between(const std::string& before, const std::string& now, const DriftArgs& args) {
  Drift drift = Drift::of_months(months_between(before, now));
  drift.beacon_m = args.beacon_m.value_or(drift.beacon_m);
  drift.delay_s = args.delay_s.value_or(drift.delay_s);
  drift.receiver_m = args.receiver_m.value_or(drift.receiver_m);
  drift.speed_mps = args.speed_mps.value_or(drift.speed_mps);
  return drift;
}

SecondVisitFiles revisit_files(const std::string& path, const std::vector<std::string>& run_paths,
                               const DriftArgs& drift, Session& session) {
  const ExitAtOnce nothing_written_yet;
  SecondVisitFiles out;
  out.before = need(io::read_deployment(path));
  warn_if_contradicted(out.before, path, session);
  std::vector<MeasurementLog> runs = read_runs(run_paths, out.before, {}, session);
  out.inputs.push_back({path, out.before.digest});
  for (const MeasurementLog& run : runs)
    for (const auto& [file, sha256] : run.sha256) out.inputs.push_back({file, sha256});
  out.head = result_head("monitoring", path, out.before, runs);
  ProgressReporter reporter(progress_style(session.options.progress, session.options.quiet));
  calib::RevisitOptions options;
  options.drift = drift_between(out.before.created, created_now(), drift);
  options.solve = solve_options(session, reporter);
  out.revisit = need(calib::revisit(out.before, std::move(runs), options));
  session.warn(out.revisit.warnings);
  if (!out.revisit.silent.empty())
    session.warn(
        fmt::format("nothing was heard of {}, though it should have been from where the vehicle was: "
                    "switched off, covered, or "
                    "taken away? What the calibration has of it is carried over",
                    fmt::join(out.revisit.silent, ", ")));
  stop_if_interrupted(out.revisit.status == calib::SolveStatus::kInterrupted);
  return out;
}

std::optional<Failure> failure_of(const calib::Revisit& revisit) {
  switch (revisit.status) {
    case calib::SolveStatus::kConverged: return std::nullopt;
    case calib::SolveStatus::kUndetermined:
      return Failure{"undetermined", "undetermined", kUndetermined,
                     revisit.message.empty() ? "the visit does not determine what changed" : revisit.message,
                     revisit.remedy.empty() ? "" : "settled by: " + revisit.remedy};
    default:
      return Failure{"not_converged", "not_converged", kNotConverged,
                     revisit.message.empty() ? "the adjustment did not converge" : revisit.message,
                     "is this a recording of the deployment's site?"};
  }
}

Json revisit_json(const SecondVisitFiles& visit, const Session& session) {
  const calib::Revisit& r = visit.revisit;
  Json beacons = Json::array(), receivers = Json::array();
  for (std::size_t b = 0; b < r.beacons.size(); ++b)
    beacons.push_back(heard_json(r.beacons[b], least_likely(r, b, false)));
  for (std::size_t k = 0; k < r.receivers.size(); ++k)
    receivers.push_back(heard_json(r.receivers[k], least_likely(r, k, true)));
  return {{"converged", r.status == calib::SolveStatus::kConverged},
          {"seconds", session.seconds()},
          {"since", visit.before.created},
          {"changes", io::json_of(r.comparison.changes)},
          {"heard", {{"beacons", beacons}, {"receivers", receivers}, {"silent", r.silent}}},
          {"p", r.comparison.p},
          {"p_left", r.comparison.p_left},
          {"medium",
           {{"temperature_known", r.medium.temperature_known},
            {"temperature_degC", r.medium.temperature_degC},
            {"speed_change_mps", r.medium.speed_change_mps},
            {"speed_change_sigma_mps", r.medium.speed_change_sigma_mps}}}};
}

std::string revisit_text(const SecondVisitFiles& visit) {
  const calib::Revisit& r = visit.revisit;
  Table table{"lrrrrr", {{"heard", "used", "late", "early", "misfit [us]", "p"}}};
  for (std::size_t b = 0; b < r.beacons.size(); ++b)
    table.rows.push_back(heard_row(r.beacons[b], least_likely(r, b, false)));
  for (std::size_t k = 0; k < r.receivers.size(); ++k)
    table.rows.push_back(heard_row(r.receivers[k], least_likely(r, k, true)));
  std::string text = table.text() + "\n" + medium_text(visit);
  const auto& changes = r.comparison.changes;
  return text + found_lines(changes) +
         (changes.empty() ? named_line("changed", "nothing beyond chance and drift")
                          : named_line("", "all else fits"));
}

bool needs_action(const Change& change, const calib::MediumFound& medium) {
  if (change.kind == ChangeKind::kSpeed) return medium.temperature_known;
  return change.kind != ChangeKind::kAmplitude;
}

}  // namespace octant::app
