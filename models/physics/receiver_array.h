// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace octant {

/// Element of a receiver array: position and axis in the vehicle frame.
struct ArrayElement {
  Eigen::Vector3d position_m;
  Eigen::Vector3d axis;  ///< unit vector
};

/// Circumradius of an octagon with sides of length side_m: side / (2 sin 22.5 deg) (65.3 mm for 50 mm).
[[nodiscard]] double octagon_radius_m(double side_m);

/// Eight receivers at the corners of a regular octagon, each facing outwards (Kleeman's array). Receiver r0
/// lies on the vehicle's +x axis rotated by turn_rad; the others follow counter-clockwise in steps of 45
/// degrees.
[[nodiscard]] std::vector<ArrayElement> octagon(double side_m, double height_m, double turn_rad = 0.0);

}  // namespace octant
