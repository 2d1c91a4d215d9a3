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
#include "apps/octant/steps/validity_words.h"
#include "apps/octant/text/changes_text.h"
#include "apps/octant/text/layout.h"
#include "io/deployment/deployment_json.h"

namespace octant::app {
namespace {

/// The most significant test of a change of one beacon or receiver.
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
  return {{"id", h.name},
          {"used", h.used},
          {"late", h.late},
          {"early", h.early},
          {"expected", std::round(h.reception.expected)},
          {"misfit_s", h.misfit_s},
          {"test", test.what},
          {"p", test.p}};
}

Json silent_json(const std::vector<Silence>& silent) {
  Json list = Json::array();
  for (const Silence& s : silent) {
    list.push_back(
        {{"subject", s.subject}, {"expected", std::round(s.expected)}, {"received", std::round(s.received)}});
    if (s.is_partial) list.back()["since_s"] = s.since_s;
  }
  return list;
}

std::vector<std::string> subjects_of(const std::vector<Silence>& silent) {
  std::vector<std::string> names;
  for (const Silence& s : silent) names.push_back(s.subject);
  return names;
}

/// Warnings about beacons that are silent or were out of reach.
void warn_of_reception(const calib::Revisit& revisit, Session& session) {
  for (const Silence& s : revisit.silent)
    session.warn(in_words(s) +
                 ": switched off, covered, or taken away? What the calibration says of it is "
                 "carried over");
  if (!revisit.not_judged.empty())
    session.warn(
        fmt::format("no change can be judged at {}: received at a single stop, where an echo looks "
                    "like a change; record more stops within its reach",
                    fmt::join(revisit.not_judged, ", ")));
  if (revisit.not_observed.empty()) return;
  const bool is_one = revisit.not_observed.size() == 1;
  session.warn(fmt::format(
      "{} {} out of reach along this path and not observed; what the calibration says of {} is carried over",
      fmt::join(revisit.not_observed, ", "), is_one ? "was" : "were", is_one ? "it" : "them"));
}

std::vector<std::string> heard_row(const calib::Heard& h, const LeastLikely& test) {
  return {h.name,
          fmt::format("{}", h.used),
          fmt::format("{}", h.late),
          fmt::format("{}", h.early),
          fmt::format("{:.0f}", h.reception.expected),
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
      "Drift since the earlier calibration (standard deviations; by default by the site file's drift, the "
      "kind of medium and the time that passed)");
  add_option(command, "--drift-beacon-m", args.beacon_m, "M",
             "Of each coordinate of a beacon; in air 0.001 and 0.0012 a year")
      ->check(CLI::PositiveNumber);
  add_option(command, "--drift-delay-s", args.delay_s, "S",
             "Of a delay; in air worth 0.001 m of range and 0.0012 m a year, by radio 0.02 m and 0.03 m")
      ->check(CLI::PositiveNumber);
  add_option(command, "--drift-receiver-m", args.receiver_m, "M",
             "Of each coordinate of a receiver; in air 0.0005 and 0.0006 a year")
      ->check(CLI::PositiveNumber);
  add_option(command, "--drift-speed-mps", args.speed_mps, "V",
             "Of the speed at the same temperature; in air 0.3 and 0.36 a year")
      ->check(CLI::PositiveNumber);
}

Drift stated_drift(const Deployment& before, const std::string& now, const DriftArgs& args) {
  Drift drift = drift_between(before, now);
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
  options.drift = stated_drift(out.before, created_now(), drift);
  options.solve = solve_options(session, reporter);
  out.revisit = need(calib::revisit(out.before, std::move(runs), options));
  session.warn(out.revisit.warnings);
  warn_of_reception(out.revisit, session);
  stop_if_interrupted(out.revisit.status == calib::SolveStatus::kInterrupted);
  return out;
}

std::optional<Failure> failure_of(const calib::Revisit& revisit) {
  switch (revisit.status) {
    case calib::SolveStatus::kConverged: return std::nullopt;
    case calib::SolveStatus::kUndetermined:
      return Failure{"undetermined", "undetermined", kUndetermined,
                     revisit.message.empty() ? "the visit does not determine what changed" : revisit.message,
                     revisit.remedy.empty() ? "" : "remedy: " + revisit.remedy};
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
          {"not_observed", r.not_observed},
          {"not_judged", r.not_judged},
          {"silent", silent_json(r.silent)},
          {"heard", {{"beacons", beacons}, {"receivers", receivers}, {"silent", subjects_of(r.silent)}}},
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
  Table table{"lrrrrrr", {{"heard", "used", "late", "early", "expected", "misfit [us]", "p"}}};
  for (std::size_t b = 0; b < r.beacons.size(); ++b)
    table.rows.push_back(heard_row(r.beacons[b], least_likely(r, b, false)));
  for (std::size_t k = 0; k < r.receivers.size(); ++k)
    table.rows.push_back(heard_row(r.receivers[k], least_likely(r, k, true)));
  std::string text = table.text() + "\n" + medium_text(visit);
  const auto& changes = r.comparison.changes;
  for (const Silence& s : r.silent) text += named_line("silent", in_words(s));
  if (!r.not_observed.empty())
    text += named_line("not observed", fmt::format("{}: out of reach along this path, carried over",
                                                   fmt::join(r.not_observed, ", ")));
  if (!r.not_judged.empty())
    text += named_line("not judged", fmt::format("{}: received at a single stop, so no change can be judged",
                                                 fmt::join(r.not_judged, ", ")));
  return text + found_lines(changes) +
         (changes.empty() ? named_line("changed", "nothing beyond chance and drift")
                          : named_line("", "all else fits"));
}

bool needs_action(const Change& change, const calib::MediumFound& medium) {
  if (change.kind == ChangeKind::kSpeed) return medium.temperature_known;
  return change.kind != ChangeKind::kAmplitude;
}

}  // namespace octant::app
