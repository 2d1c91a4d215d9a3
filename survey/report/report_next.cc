// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "survey/geometry/quantity.h"
#include "survey/report/report.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

/// Below this mean redundancy number most of an arrival's error goes into the beacon and not into its
/// residual.
constexpr double kLittleRedundancy = 0.3;
/// Beyond these the stated noise is wrong, whatever the test says of a small number of arrivals.
constexpr double kNoisy = 2.0, kQuiet = 0.5;
constexpr std::size_t kMostNames = 6;

std::string names(const std::vector<std::string>& all) {
  std::string text;
  for (std::size_t i = 0; i < all.size() && i < kMostNames; ++i) text += (i == 0 ? "" : ", ") + all[i];
  return all.size() > kMostNames ? text + fmt::format(" and {} more", all.size() - kMostNames) : text;
}

/// One step for each remedy, which may cover several findings.
void add_weak(const ReportInput& input, std::vector<std::string>& steps) {
  for (const bool blocking : {true, false}) {
    std::vector<std::pair<std::string, std::vector<std::string>>> by_remedy;
    for (const auto& weak : input.weak) {
      if (weak.blocking != blocking || weak.remedy.empty()) continue;
      auto at = std::ranges::find_if(by_remedy, [&](const auto& of) { return of.first == weak.remedy; });
      if (at == by_remedy.end()) at = by_remedy.insert(at, {weak.remedy, {}});
      if (std::ranges::find(at->second, weak.description) == at->second.end())
        at->second.push_back(weak.description);
    }
    for (const auto& [remedy, settles] : by_remedy)
      steps.push_back(as_sentence(fmt::format("To determine {}: {}", names(settles), remedy)));
  }
}

void add_beacons(const ReportInput& input, std::vector<std::string>& steps) {
  std::vector<std::string> lost, bare, beyond;
  const Deployment& d = input.plan.deployment;
  for (const auto& beacon : d.beacons) {
    if (beacon.status == BeaconStatus::kUndetermined) lost.push_back(beacon.name);
    if (beacon.status == BeaconStatus::kCalibrated && d.tolerance.beacon_m &&
        radius95_m(beacon) > *d.tolerance.beacon_m)
      beyond.push_back(beacon.name);
  }
  for (const auto& note : input.beacons) {
    const bool counts = std::ranges::find(lost, note.name) == lost.end();
    if (counts && note.used > 0 && note.redundancy < kLittleRedundancy) bare.push_back(note.name);
  }
  const bool told = std::ranges::any_of(input.weak, [](const WeakNote& weak) { return weak.lone_beacon; });
  if (!lost.empty() && !told && input.outcome == Outcome::kCalibrated)
    steps.push_back(
        fmt::format("Hear {} from more places, well apart: not determined, localizers leave {} out.",
                    names(lost), lost.size() > 1 ? "them" : "it"));
  if (!beyond.empty())
    steps.push_back(
        fmt::format("Record more stations around {}: beyond the tolerance for beacons.", names(beyond)));
  if (!bare.empty())
    steps.push_back(
        fmt::format("Record more stations that hear {}: with redundancy numbers below {} errors of single "
                    "arrivals stay unseen.",
                    names(bare), kLittleRedundancy));
}

/// If a quarter or more was left out: by the most frequent reason.
void add_left_out(const ReportInput& input, std::vector<std::string>& steps) {
  const CalibrationStatistics& s = input.plan.deployment.statistics;
  const std::size_t left_out = s.rejected, all = s.arrivals + s.rejected;
  if (left_out * 4 <= all) return;
  std::size_t late = 0, early = 0, no_pose = 0;
  const LeftOutNote* most = nullptr;
  for (const LeftOutNote& note : input.left_out) {
    if (note.cause == LeftOutCause::kLate) late += note.count;
    if (note.cause == LeftOutCause::kEarly) early += note.count;
    if (note.cause == LeftOutCause::kNoPose) no_pose += note.count;
    if (most == nullptr || note.count > most->count) most = &note;
  }
  const std::size_t other = left_out - std::min(left_out, late + early + no_pose);
  if (no_pose > late + early && no_pose >= other)
    steps.push_back(
        fmt::format("Tell where the vehicle was: {} of {} arrivals count for nothing, as their vehicle has "
                    "no pose. A stop "
                    "takes three beacons that do not hang in one line; a drive, odometry or measured poses "
                    "that cover it.",
                    no_pose, all));
  else if (late + early >= other && late > 2 * early)
    steps.push_back(
        fmt::format("Look for reflectors and obstacles: {} of {} arrivals were left out, {} of them late.",
                    left_out, all, late));
  else if (late + early >= other && late + early > 0)
    steps.push_back(
        fmt::format("Look for reflecting walls and swapped channels: {} of {} arrivals were left out, {} "
                    "late and {} early.",
                    left_out, all, late, early));
  else
    steps.push_back(
        fmt::format("Look at what was left out: {} of {} arrivals{}.", left_out, all,
                    most == nullptr ? "" : fmt::format(", {} for \"{}\"", most->count, most->reason)));
}

void add_noise(const ReportInput& input, std::vector<std::string>& steps) {
  const CalibrationStatistics& s = input.plan.deployment.statistics;
  if (s.redundancy < 10 || s.variance_factor <= 0) return;
  if (input.plan.deployment.contradictions.empty() &&
      (s.variance_factor > kNoisy || s.variance_factor < kQuiet))
    steps.push_back(
        fmt::format("State the noise as it is: residuals have {:.2g} times the variance of noise.tof_sigma_s "
                    "in the site file.",
                    s.variance_factor));
  add_left_out(input, steps);
}

void add_verification(const ReportInput& input, std::vector<std::string>& steps) {
  const Tolerance& tolerance = input.plan.deployment.tolerance;
  if (!input.evaluation) {
    steps.emplace_back(
        "Verify with a run that took no part in the calibration and whose poses are known: octant verify.");
  } else if (!input.evaluation->pass()) {
    steps.emplace_back(input.evaluation->matched == 0
                           ? "Record a held-out run whose truth.tum covers the fixes in time."
                           : "Fixes are outside their tolerance: see the plan for their places, and add a "
                             "beacon or stations there.");
  } else if (input.evaluation->nees_mean && *input.evaluation->nees_mean > 3.0) {
    steps.push_back(
        fmt::format("Do not trust the stated sigmas of fixes: errors are {:.2g} times as large squared; look "
                    "for reflections and unmodelled delays.",
                    *input.evaluation->nees_mean));
  }
  if (!tolerance.beacon_m && !tolerance.fix_m)
    steps.emplace_back(
        "State in the site file what the site must reach (tolerance: beacon_m, fix_m), so that it can be "
        "judged.");
}

}  // namespace

std::vector<std::string> next_steps(const ReportInput& input) {
  std::vector<std::string> steps;
  for (const Contradiction& c : input.plan.deployment.contradictions) {
    const std::string step = as_sentence(c.remedy);
    if (!c.remedy.empty() && std::ranges::find(steps, step) == steps.end()) steps.push_back(step);
  }
  if (!steps.empty()) {
    steps.emplace_back(
        "Then calibrate again: what else is to be measured shows when nothing is contradicted any more.");
    return steps;
  }
  if (input.outcome == Outcome::kNotConverged)
    steps.emplace_back("Check units, beacon ids and approximate positions: octant check looks at the log.");
  add_weak(input, steps);
  add_beacons(input, steps);
  if (input.changes) {
    std::vector<std::string> moved, delayed;
    for (const auto& c : input.changes->beacons) {
      if (c.moved()) moved.push_back(c.name);
      if (c.delay_significant && !c.moved()) delayed.push_back(c.name);
    }
    const std::vector<std::string>& doubted = input.changes->doubted_control_points;
    if (!doubted.empty())
      steps.push_back(fmt::format(
          "Measure {} again: held as a control point, with another delay than in the earlier deployment.",
          names(doubted)));
    if (!moved.empty())
      steps.push_back(fmt::format("Look at {} on site: moved since the earlier deployment.", names(moved)));
    for (const Silence& s : input.changes->silent)
      steps.push_back(fmt::format("Look at {} on site: {}.", s.subject, reception_words(s)));
    const bool all_later = std::ranges::any_of(
        input.changes->found, [](const Change& c) { return c.subject == kAllBeaconsSubject; });
    if (all_later)
      steps.emplace_back(
          "Look at the vehicle's electronics and the synchronisation: all delays differ by the same from "
          "those of the "
          "earlier deployment.");
    if (!delayed.empty() && !all_later)
      steps.push_back(fmt::format(
          "Look at {} on site: another delay than in the earlier deployment, as of another device.",
          names(delayed)));
  }
  if (input.outcome == Outcome::kCalibrated) {
    add_noise(input, steps);
    add_verification(input, steps);
  }
  if (steps.empty())
    steps.emplace_back(
        "Nothing needs to be measured; keep this report to compare the next calibration with it.");
  return steps;
}

std::optional<ReportSection> next_section(const ReportInput& input) {
  return ReportSection{"next", "What to do next", {ReportList{next_steps(input), true}}};
}

}  // namespace octant::survey
