// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Core>

#include "models/physics/pose.h"
#include "models/site.h"

namespace octant {

/// Pose of a vehicle at distance s along its rail, and its derivative. Straight rail: s from its beginning.
/// Arc: s = R phi, counter-clockwise from the centre's +x axis, in (-pi R, pi R].
struct RailPoint {
  Pose T_map_vehicle;
  Eigen::Vector3d by_s = Eigen::Vector3d::Zero();  ///< derivatives of x, y, heading by s
};
[[nodiscard]] RailPoint rail_point(const Rail& rail, double s_m);

/// Length of a straight rail, or of the whole circle of an arc, whose ends a site does not specify [m].
[[nodiscard]] double rail_length_m(const Rail& rail);

/// Wraps s into the interval of an arc; no change on a straight rail.
[[nodiscard]] double rail_wrapped_m(const Rail& rail, double s_m);

/// Positions along a rail at which a receiver is at a given distance from a beacon.
struct RailPlaces {
  std::array<double, 2> s_m{};
  int count = 0;  ///< 0: no solution, or every position (a beacon above the centre of an arc)
};

/// Intersects a receiver's own path (parallel to the rail, or a circle with the same centre) with the circle
/// of a range.
/// @param o_vehicle_m  position of the receiver on the vehicle  @param range_m  slant range
/// @param slack_m  tolerance by which a range may be shorter than the shortest, or (arc) longer than the
/// longest, possible one
[[nodiscard]] RailPlaces rail_places(const Rail& rail, const Eigen::Vector3d& o_vehicle_m,
                                     const Eigen::Vector3d& p_beacon_m, double range_m, double slack_m);

}  // namespace octant
