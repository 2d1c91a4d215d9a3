// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/left_out.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "calib/problem/gates.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

constexpr double kMostly = 0.5;
constexpr std::size_t kEnoughBearings = 5;  ///< least number of bearings for a warning on a reflector

std::vector<LeftOut> arrivals_of(const Trajectory& t, const SharedState& state) {
  std::vector<LeftOut> out;
  for (const std::size_t i : t.stateless_arrivals) out.push_back({t.run, i, Rejection::kNoPose, 0.0});
  for (const ArrivalObservation& a : t.arrivals) {
    if (a.rejection == Rejection::kUsed) continue;
    const bool placed = is_outlier(a.rejection) || is_gated(a.rejection);
    out.push_back({t.run, a.arrival, a.rejection, placed ? a.sigma_s * arrival_residual(t, a, state) : 0.0});
  }
  return out;
}

/// Rejected bearings of one run. A bearing without a state is in no trajectory.
std::vector<LeftOutBearing> bearings_of(const MeasurementLog& log, std::size_t run,
                                        const std::vector<Trajectory>& trajectories) {
  std::vector<LeftOutBearing> out;
  std::vector<std::uint8_t> carried(log.bearings.size(), 0);
  for (const Trajectory& t : trajectories) {
    if (t.run != run) continue;
    for (const BearingObservation& b : t.bearings) {
      carried[b.bearing] = 1;
      if (b.rejection != Rejection::kUsed) out.push_back({run, b.bearing, b.rejection});
    }
  }
  for (std::size_t i = 0; i < carried.size(); ++i)
    if (carried[i] == 0) out.push_back({run, i, Rejection::kNoPose});
  return out;
}

/// Measured poses of a run that no arrival or bearing needs, or that are separated by a long gap.
std::vector<LeftOutPose> poses_of(const MeasurementLog& log, std::size_t run,
                                  const std::vector<Trajectory>& trajectories) {
  std::vector<std::uint8_t> needed(log.poses.size(), 0);
  for (const Trajectory& t : trajectories) {
    if (t.run != run || !t.moving || t.odometry.empty()) continue;
    for (std::size_t i = 0; i < needed.size(); ++i)  // odometry needs each of them
      if (log.poses[i].time_s >= t.nodes.front().time_s && log.poses[i].time_s <= t.nodes.back().time_s)
        needed[i] = 1;
  }
  const auto mark = [&](double time_s) {
    const auto after = std::lower_bound(log.poses.begin(), log.poses.end(), time_s,
                                        [](const TimedPose& p, double t) { return p.time_s < t; });
    if (after == log.poses.end()) return;
    const auto k = static_cast<std::size_t>(after - log.poses.begin());
    if (after->time_s == time_s) {
      needed[k] = 1;
    } else if (k > 0 && after->time_s - log.poses[k - 1].time_s <= log.pose_accuracy.max_gap_s) {
      needed[k] = needed[k - 1] = 1;
    }
  };
  for (const Arrival& a : log.arrivals) mark(a.time_s);
  for (const Bearing& b : log.bearings) mark(b.time_s);
  std::vector<LeftOutPose> out;
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (needed[i] == 0) out.push_back({run, i, Rejection::kNotNeeded});
  return out;
}

template <class List>
void append(List& to, List&& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

LeftOutOfAll left_out_of(const Problem& problem, const std::vector<Trajectory>& trajectories,
                         const SharedState& state) {
  LeftOutOfAll out;
  for (const Trajectory& t : trajectories) append(out.arrivals, arrivals_of(t, state));
  for (std::size_t run = 0; run < problem.runs.size(); ++run) {
    append(out.bearings, bearings_of(problem.runs[run], run, trajectories));
    append(out.poses, poses_of(problem.runs[run], run, trajectories));
  }
  return out;
}

RejectionCounts arrivals_by_outcome(const Problem& problem, const Solution& solution) {
  RejectionCounts counts;
  if (solution.totals) {
    for (const RejectionCounts& of_beacon : solution.totals->of_beacon) counts.add(of_beacon);
    return counts;
  }
  std::size_t rows = 0;
  for (const MeasurementLog& run : problem.runs) rows += run.arrivals.size();
  for (const LeftOut& l : solution.left_out) counts.add(l.reason);
  counts.add(Rejection::kUsed, rows - std::min(rows, solution.left_out.size()));
  return counts;
}

bool are_many_left_out(const Problem& problem, const Solution& solution) {
  constexpr double kMany = 0.35;
  const RejectionCounts counts = arrivals_by_outcome(problem, solution);
  return static_cast<double>(counts.all() - counts.of(Rejection::kUsed)) >
         kMany * static_cast<double>(counts.all());
}

std::vector<std::string> bearings_in_doubt(const Problem& problem,
                                           const std::vector<LeftOutBearing>& left_out) {
  std::vector<std::size_t> all(problem.site.beacons.size(), 0), out(all);
  for (const MeasurementLog& run : problem.runs)
    for (const Bearing& b : run.bearings)
      if (b.reflector.valid()) ++all[b.reflector.index()];
  for (const LeftOutBearing& b : left_out) {
    const BeaconId reflector = problem.runs[b.run].bearings[b.bearing].reflector;
    if (reflector.valid() && is_outlier(b.reason)) ++out[reflector.index()];
  }
  std::vector<std::string> warnings;
  for (std::size_t b = 0; b < all.size(); ++b)
    if (all[b] >= kEnoughBearings && static_cast<double>(out[b]) > kMostly * static_cast<double>(all[b]))
      warnings.push_back(
          fmt::format("beacon {}: {} of {} bearings do not fit its position and are left out; its position "
                      "is in doubt, check its label and where it is received",
                      problem.site.beacons[b].name, out[b], all[b]));
  return warnings;
}

}  // namespace octant::calib
