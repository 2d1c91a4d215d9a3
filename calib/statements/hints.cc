// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/hints.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/problem/subsample.h"
#include "calib/statements/suspicions.h"

namespace octant::calib {
namespace {

constexpr std::size_t kRows = 20'000, kBlocks = 40;  ///< examined rows and blocks of a long recording
constexpr std::size_t kStops = 1000;

/// Evenly spread blocks of rows, extended to whole stops. A short recording is returned unchanged.
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

/// Returns true for findings that require all rows: in blocks they would report the pauses between these, or
/// data that the blocks do not contain.
bool needs_all(const Finding& f) {
  return f.kind == "gap" || f.kind == "constant" || f.kind == "temperature";
}

/// Finds beacons without any arrival in recordings in which many rows were rejected.
std::vector<Finding> beacons_without_measurement(const Site& site, const std::vector<MeasurementLog>& runs) {
  constexpr std::size_t kMany = 10;
  std::vector<std::size_t> arrivals(site.beacons.size(), 0);
  std::map<std::string, std::size_t> rejected;
  for (const MeasurementLog& run : runs) {
    for (const Arrival& a : run.arrivals) ++arrivals[a.beacon.index()];
    for (const RejectedRow& row : run.rejected) ++rejected[row.reason];
  }
  const auto most = std::ranges::max_element(rejected, {}, [](const auto& reason) { return reason.second; });
  std::vector<Finding> findings;
  if (most == rejected.end() || most->second < kMany) return findings;
  for (std::size_t b = 0; b < arrivals.size(); ++b)
    if (arrivals[b] == 0)
      findings.push_back(
          {"beacon_without_measurement",
           fmt::format("beacon {} has no usable arrival, while {} rows were rejected ({}). If they are its "
                       "own, it has a wrong constant delay or sends a default value: check its settings",
                       site.beacons[b].name, most->second, most->first)});
  return findings;
}

}  // namespace

/// Finds positions without a sigma at a site without a control point. This is usually an oversight.
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

std::vector<Finding> log_hints(const Site& site, const std::vector<MeasurementLog>& runs, bool are_complete) {
  std::vector<Finding> findings = site_hints(site);
  for (Finding& f : beacons_without_measurement(site, runs)) findings.push_back(std::move(f));
  std::vector<RunHealth> health;
  bool all = true;
  for (const MeasurementLog& run : runs) {
    const bool is_short = run.arrivals.size() <= 2 * kRows, is_whole = is_short && are_complete;
    all = all && is_whole;
    health.push_back(log_health(site, is_short ? run : some_blocks(run)));
    for (Finding& f : health.back().findings)
      if (is_whole || !needs_all(f)) findings.push_back(std::move(f));
  }
  if (all)
    for (Finding& f : silent_links(site, health))
      if (f.kind != "silent_beacon") findings.push_back(std::move(f));  // reported by the calibration itself
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

}  // namespace octant::calib
