// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "models/physics/pose.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Poses taken as exact still need a finite weight; a micrometre is far below any beacon system.
inline constexpr double kExactPositionM = 1e-6;
inline constexpr double kExactAngleRad = 1e-6;

/// Odometry of one vehicle summed up: the path from its anchor, with the variances along it.
struct OdometryPath {
  std::vector<double> time_s;
  std::vector<Pose> T_anchor_vehicle;
  std::vector<double> distance_variance_m2, heading_variance_rad2;  ///< of the step that ends at the row
};
[[nodiscard]] OdometryPath odometry_path(const MeasurementLog& log, VehicleId vehicle);

/// A place on the path between a row and the next.
struct PathPlace {
  std::size_t row = 0;
  double alpha = 0.0;
};
/// Place of the path at a time; none outside.
[[nodiscard]] std::optional<PathPlace> place_at(const OdometryPath& path, double time_s);

/// Pose of asking in the frame of that of hearing, of two-way ranging; none where the path does not hold
/// both.
[[nodiscard]] std::optional<Pose> hear_send_motion(const OdometryPath& path, const Arrival& arrival);

/// Odometry between two instants as one observation; false where the path does not hold both.
bool path_between(const OdometryPath& path, double from_s, double to_s, OdometryObservation& o);

}  // namespace octant
