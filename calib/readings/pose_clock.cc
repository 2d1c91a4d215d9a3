// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_clock.h"

#include <cstddef>
#include <optional>

#include "models/trajectory/trajectory.h"

namespace octant::calib {
namespace {

/// Calls visit(time_s) for some arrivals, evenly spread. @return for which share of them it is true
template <class Visit>
double share_of_arrivals(const MeasurementLog& run, Visit&& visit) {
  constexpr std::size_t kArrivals = 500;
  const std::size_t n = run.arrivals.size(), stride = n / kArrivals + 1;
  std::size_t seen = 0, count = 0;
  for (std::size_t i = 0; i < n; i += stride, ++seen) count += visit(run.arrivals[i].time_s) ? 1 : 0;
  return seen > 0 ? static_cast<double>(count) / static_cast<double>(seen) : 0.0;
}

std::optional<Pose> pose_at(const MeasurementLog& run, double time_s) {
  Pose pose;
  return interpolate_poses(run.poses, time_s, run.pose_accuracy.max_gap_s, pose) ? std::optional(pose)
                                                                                 : std::nullopt;
}

}  // namespace

bool poses_are_of_motion(const MeasurementLog& run) {
  constexpr double kApart_s = 0.5, kSlowest_mps = 0.03, kMovingShare = 0.1;
  return share_of_arrivals(run, [&](double time_s) {
           const auto before = pose_at(run, time_s - kApart_s / 2),
                      after = pose_at(run, time_s + kApart_s / 2);
           return before && after &&
                  (after->translation_m - before->translation_m).norm() > kSlowest_mps * kApart_s;
         }) > kMovingShare;
}

double share_with_pose(const MeasurementLog& run, double lag_s) {
  return share_of_arrivals(run, [&](double time_s) { return pose_at(run, time_s + lag_s).has_value(); });
}

void take_back_lag(double lag_s, MeasurementLog& run) {
  for (TimedPose& pose : run.poses) pose.time_s -= lag_s;
}

}  // namespace octant::calib
