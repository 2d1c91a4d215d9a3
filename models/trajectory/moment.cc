// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/moment.h"

#include <algorithm>

#include "models/trajectory/trajectory.h"

namespace octant {
namespace {

constexpr double kMoment_s = 0.01;  ///< no sound takes longer to pass a vehicle
constexpr double kStandsStill = 0.1;

}  // namespace

std::size_t end_of_moment(const MeasurementLog& log, const std::vector<std::size_t>& arrivals,
                          std::size_t first, const Pose* T, double noise_m) {
  const PoseAccuracy& accuracy = log.pose_accuracy;
  const double time_s = log.arrivals[arrivals[first]].time_s,
               still_m = kStandsStill * std::min(accuracy.position_sigma_m, noise_m),
               still_rad = kStandsStill * accuracy.attitude_sigma_rad;
  const auto belongs = [&](double other_s) {
    if (other_s == time_s) return true;
    Pose other;
    return T != nullptr && other_s - time_s <= kMoment_s &&
           interpolate_poses(log.poses, other_s, accuracy.max_gap_s, other) &&
           (other.translation_m - T->translation_m).norm() <= still_m &&
           other.rotation.angularDistance(T->rotation) <= still_rad;
  };
  std::size_t last = first + 1;
  while (last < arrivals.size() && belongs(log.arrivals[arrivals[last]].time_s)) ++last;
  return last;
}

}  // namespace octant
