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
    const OdometryVariance variance = variance_of(step, log.odometry_accuracy);
    path.time_s.push_back(step.time_s);
    path.T_anchor_vehicle.push_back(T);
    path.distance_variance_m2.push_back(variance.distance_m2);
    path.heading_variance_rad2.push_back(variance.heading_rad2);
    first = false;
  }
  return path;
}

bool path_at(const OdometryPath& path, double time_s, Pose& T) {
  if (path.time_s.size() < 2 || time_s < path.time_s.front() || time_s > path.time_s.back()) return false;
  auto after = static_cast<std::size_t>(std::upper_bound(path.time_s.begin(), path.time_s.end(), time_s) -
                                        path.time_s.begin());
  after = std::min(after, path.time_s.size() - 1);
  const double span = path.time_s[after] - path.time_s[after - 1];
  T = interpolate(path.T_anchor_vehicle[after - 1], path.T_anchor_vehicle[after],
                  span > 0 ? (time_s - path.time_s[after - 1]) / span : 0.0);
  return true;
}

std::optional<Pose> hear_send_motion(const OdometryPath& path, const Arrival& arrival) {
  Pose hear, send;
  if (!path_at(path, arrival.time_s, hear) || !path_at(path, arrival.time_s - arrival.tof_s, send)) return {};
  return hear.inverse() * send;
}

bool path_between(const OdometryPath& path, double from_s, double to_s, OdometryObservation& o) {
  Pose A, B;
  if (!path_at(path, from_s, A) || !path_at(path, to_s, B)) return false;
  o.T_before_after = A.inverse() * B;
  double distance = 0.0, heading = 0.0;
  const auto first = std::upper_bound(path.time_s.begin(), path.time_s.end(), from_s) - path.time_s.begin();
  for (auto k = static_cast<std::size_t>(first); k < path.time_s.size() && path.time_s[k - 1] < to_s; ++k) {
    distance += path.distance_variance_m2[k];
    heading += path.heading_variance_rad2[k];
  }
  // A turn that is off by h moves the end of the step by half of it across.
  o.distance_sigma_m =
      std::sqrt(std::max(distance + heading * o.T_before_after.translation_m.squaredNorm() / 3,
                         kExactPositionM * kExactPositionM));
  o.heading_sigma_rad = std::sqrt(std::max(heading, kExactAngleRad * kExactAngleRad));
  return true;
}

}  // namespace octant
