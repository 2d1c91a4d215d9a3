// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/odometry_path.h"

#include <algorithm>
#include <cmath>

#include "models/trajectory/odometry_noise.h"

namespace octant {

OdometryPath odometry_path(const MeasurementLog& log, VehicleId vehicle) {
  OdometryPath path;
  Pose T;
  bool first = true;
  for (const OdometryStep& step : log.odometry) {
    if (step.vehicle != vehicle) continue;
    if (!first) T = T * step.pose();
    const OdometryVariance variance = estimation_variance_of(step, log.odometry_accuracy);
    path.time_s.push_back(step.time_s);
    path.T_anchor_vehicle.push_back(T);
    path.distance_variance_m2.push_back(variance.distance_m2);
    path.heading_variance_rad2.push_back(variance.heading_rad2);
    first = false;
  }
  return path;
}

std::optional<PathPlace> place_at(const OdometryPath& path, double time_s) {
  const auto& times = path.time_s;
  if (times.size() < 2 || time_s < times.front() || time_s > times.back()) return {};
  const auto after = static_cast<std::size_t>(std::ranges::upper_bound(times, time_s) - times.begin());
  const std::size_t row = std::min(after, times.size() - 1) - 1;
  const double span = times[row + 1] - times[row];
  return PathPlace{row, span > 0 ? (time_s - times[row]) / span : 0.0};
}

namespace {

/// Pose at one instant in the frame of the pose at the other, in either order.
std::optional<Pose> motion_between(const OdometryPath& path, double from_s, double to_s) {
  const auto from = place_at(path, from_s), to = place_at(path, to_s);
  if (!from || !to) return {};
  const auto pose = [&path](const PathPlace& at) {
    return interpolate(path.T_anchor_vehicle[at.row], path.T_anchor_vehicle[at.row + 1], at.alpha);
  };
  return pose(*from).inverse() * pose(*to);
}

}  // namespace

std::optional<Pose> hear_send_motion(const OdometryPath& path, const Arrival& arrival) {
  return motion_between(path, arrival.time_s, arrival.time_s - arrival.tof_s);
}

bool path_between(const OdometryPath& path, double from_s, double to_s, OdometryObservation& o) {
  const auto step = motion_between(path, from_s, to_s);
  if (!step) return false;
  o.T_before_after = *step;
  double distance = 0.0, heading = 0.0;
  const auto first = std::ranges::upper_bound(path.time_s, from_s) - path.time_s.begin();
  for (auto k = static_cast<std::size_t>(first); k < path.time_s.size() && path.time_s[k - 1] < to_s; ++k) {
    distance += path.distance_variance_m2[k];
    heading += path.heading_variance_rad2[k];
  }
  // A heading error h displaces the end of the step sideways by h / 2 times its length.
  o.distance_sigma_m =
      std::sqrt(std::max(distance + heading * o.T_before_after.translation_m.squaredNorm() / 3,
                         kExactPositionM * kExactPositionM));
  o.heading_sigma_rad = std::sqrt(std::max(heading, kExactAngleRad * kExactAngleRad));
  return true;
}

}  // namespace octant
