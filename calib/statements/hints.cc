// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/hints.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/plan/check.h"
#include "calib/problem/subsample.h"
#include "calib/readings/readings.h"
#include "calib/readings/seems_misread.h"

namespace octant::calib {
namespace {

constexpr std::size_t kRows = 20'000, kBlocks = 40;  ///< of a recording, looked at
constexpr std::size_t kStops = 1000;

/// Evenly spread blocks of rows, each as long as stops allow; a short recording as it is.
MeasurementLog some_blocks(const MeasurementLog& run) {
  MeasurementLog blocks = without_lists(run);
  blocks.odometry = run.odometry;
  blocks.poses = run.poses;
  const std::size_t length = kRows / kBlocks, n = run.arrivals.size();
  const auto is_seam = [&](std::size_t i) {
    return i == n || !run.has_epochs || run.arrivals[i].epoch != run.arrivals[i - 1].epoch;
  };
  for (std::size_t block = 0; block < kBlocks; ++block) {
    std::size_t begin = block * n / kBlocks, end = begin + length;
    while (begin > 0 && begin < n && !is_seam(begin)) ++begin;
    while (end < n && !is_seam(end) && end < begin + 2 * length) ++end;
    const auto at = [&](std::size_t i) {
      return run.arrivals.begin() + static_cast<std::ptrdiff_t>(std::min(i, n));
    };
    if (begin < end) blocks.arrivals.insert(blocks.arrivals.end(), at(begin), at(end));
  }
  return blocks;
}

/// Said of blocks it would be of the pauses between them, or of what they happen not to hold.
bool needs_all(const Finding& f) {
  return f.kind == "gap" || f.kind == "constant" || f.kind == "temperature";
}

/// Where much is left out, and not as echoes are late, something that was stated is wrong, whatever it is.
std::optional<Contradiction> early_beyond_chance(const Problem& problem, const Solution& solution) {
  constexpr double kMuchLeftOut = 0.3, kMuchEarly = 0.1;
  if (solution.status != SolveStatus::kConverged) return {};
  std::size_t all = 0, out = 0, early = 0;
  for (const MeasurementLog& run : problem.runs) all += run.arrivals.size();
  for (const LeftOut& l : solution.left_out) {
    out += is_outlier(l.reason);
    early += l.reason == Rejection::kEarly;
  }
  const auto rows = static_cast<double>(all);
  if (static_cast<double>(out) < kMuchLeftOut * rows || static_cast<double>(early) < kMuchEarly * rows)
    return {};
  return Contradiction{
      ContradictionKind::kLog,
      "as a whole",
      "heard along straight paths",
      fmt::format("{} of {} arrivals not to fit, {} of them early, as no echo can be", out, all, early),
      0.0,
      "look at the places of control points and receivers, at which is wired as which, and at labels, units "
      "and frames; then calibrate again"};
}

}  // namespace

/// Places that hold nothing, at a site without a control point: an oversight more often than not.
std::vector<Finding> site_hints(const Site& site) {
  std::vector<std::string> loose;
  std::size_t placed = 0;
  for (const SiteBeacon& b : site.beacons) {
    if (b.is_control_point()) return {};
    if (!b.position_m[0] || !b.position_m[1]) continue;
    ++placed;
    if (!b.sigma_m[0] && !b.sigma_m[1] && !b.sigma_m[2]) loose.push_back(b.name);
  }
  if (loose.empty()) return {};
  constexpr std::size_t kNamed = 6;
  std::string who = fmt::format("none of the {} beacons with a position_m has a sigma_m", placed);
  if (loose.size() < placed) {
    const std::size_t named = std::min(loose.size(), kNamed);
    who =
        fmt::format("{} of {} beacons with a position_m have no sigma_m ({}{}), and none is a control point",
                    loose.size(), placed,
                    fmt::join(loose.begin(), loose.begin() + static_cast<std::ptrdiff_t>(named), ", "),
                    named < loose.size() ? ", ..." : "");
  }
  return {{"no_sigma", fmt::format("{}: {}: their places serve as a start only and hold nothing; state "
                                   "sigma_m: 0.0 for those that were surveyed",
                                   site.path, who)}};
}

std::vector<Finding> log_hints(const Site& site, const std::vector<MeasurementLog>& runs) {
  std::vector<Finding> findings = site_hints(site);
  std::vector<RunHealth> health;
  bool all = true;
  for (const MeasurementLog& run : runs) {
    const bool is_short = run.arrivals.size() <= 2 * kRows;
    all = all && is_short;
    health.push_back(log_health(site, is_short ? run : some_blocks(run)));
    for (Finding& f : health.back().findings)
      if (is_short || !needs_all(f)) findings.push_back(std::move(f));
  }
  if (all)
    for (Finding& f : silent_links(site, health))
      if (f.kind != "silent_beacon") findings.push_back(std::move(f));  // calibration says so itself
  return findings;
}

std::vector<Finding> outcome_hints(const Problem& problem, const Solution& solution) {
  if (solution.beacon_status.empty()) return {};
  std::vector<RunHealth> runs(problem.runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].path = problem.runs[i].path;
  std::size_t stops = 0;
  for (const Trajectory& t : solution.trajectories) stops += t.segments.size();
  const std::size_t stride = stops / kStops + 1;
  if (stride == 1)
    return suspicions(Adjusted{problem.site, solution.state, solution.trajectories, 1.0}, runs);
  std::vector<Trajectory> sample;
  for (const Trajectory& t : solution.trajectories) sample.push_back(some_segments(t, stride));
  return suspicions(Adjusted{problem.site, solution.state, sample, static_cast<double>(stride)}, runs);
}

void explain(const Problem& problem, const Problem& adjusted, Solution& solution,
             const SolveOptions& options) {
  const bool misread = seems_misread(adjusted, solution);
  if (!misread && solution.contradictions.empty()) return;
  std::vector<Contradiction> found = misread ? find_misreadings(problem, solution, options)
                                             : find_other_culprits(problem, solution, options);
  if (found.empty()) {
    if (auto early = early_beyond_chance(adjusted, solution); early && solution.contradictions.empty())
      solution.contradictions.push_back(std::move(*early));
    return;
  }
  solution.contradictions = std::move(found);
  if (solution.status != SolveStatus::kUndetermined) return;
  solution.message = "the recordings do not fit what was stated, and nothing is exported";
  solution.weak.clear();
}

}  // namespace octant::calib
