// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Core>

#include "models/physics/pose.h"
#include "models/site.h"

namespace octant {

/// A vehicle that is s along its rail: its pose, and how that changes with s.
/// Straight: s from the rail's beginning. Arc: s = R phi, counter-clockwise from the centre's +x axis, in
/// (-pi R, pi R].
struct RailPoint {
  Pose T_map_vehicle;
  Eigen::Vector3d by_s = Eigen::Vector3d::Zero();  ///< x, y, heading per metre
};
[[nodiscard]] RailPoint rail_point(const Rail& rail, double s_m);

/// Length of a straight rail; an arc's whole circle, because a site does not say where it ends [m].
[[nodiscard]] double rail_length_m(const Rail& rail);

/// s brought into a rail's own interval: no change on a straight one.
[[nodiscard]] double rail_wrapped_m(const Rail& rail, double s_m);

/// Places along a rail at which a receiver is at a distance from a beacon.
struct RailPlaces {
  std::array<double, 2> s_m{};
  int count = 0;  ///< 0: nowhere, or everywhere (a beacon above the centre of an arc)
};

/// Where a receiver's own line (parallel to the rail, or a circle about the same centre) meets the circle of
/// a range.
/// @param o_vehicle_m  the receiver's place on the vehicle  @param range_m  slant
/// @param slack_m  a range too short by less than this counts as the shortest, and too long (arc) as the
/// longest
[[nodiscard]] RailPlaces rail_places(const Rail& rail, const Eigen::Vector3d& o_vehicle_m,
                                     const Eigen::Vector3d& p_beacon_m, double range_m, double slack_m);

}  // namespace octant
