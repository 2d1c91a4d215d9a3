// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "models/physics/pose.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Lower bounds on the sigmas of poses that are declared exact, to keep weights finite. A micrometre is far
/// below the noise of any beacon system.
inline constexpr double kExactPositionM = 1e-6;
inline constexpr double kExactAngleRad = 1e-6;

/// Integrated odometry of one vehicle: poses relative to the anchor, and the variances along the path.
struct OdometryPath {
  std::vector<double> time_s;
  std::vector<Pose> T_anchor_vehicle;
  std::vector<double> distance_variance_m2,
      heading_variance_rad2;  ///< variances of the step that ends at the row
};
[[nodiscard]] OdometryPath odometry_path(const MeasurementLog& log, VehicleId vehicle);

/// Position on the path between a row and the next one.
struct PathPlace {
  std::size_t row = 0;
  double alpha = 0.0;
};
/// Position on the path at a time; no value outside its time span.
[[nodiscard]] std::optional<PathPlace> place_at(const OdometryPath& path, double time_s);

/// Two-way ranging: pose at the request in the frame of the pose at reception. No value if the path does not
/// cover both.
[[nodiscard]] std::optional<Pose> hear_send_motion(const OdometryPath& path, const Arrival& arrival);

/// Combines the odometry between two instants into one observation; false if the path does not cover both.
bool path_between(const OdometryPath& path, double from_s, double to_s, OdometryObservation& o);

}  // namespace octant
