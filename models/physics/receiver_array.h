// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace octant {

/// Corner of a receiver array: place and direction of hearing in the vehicle frame.
struct ArrayElement {
  Eigen::Vector3d position_m;
  Eigen::Vector3d axis;  ///< unit vector
};

/// Circumradius of the octagon whose neighbouring corners are side_m apart: side / (2 sin 22.5 deg) (65.3 mm
/// for 50 mm).
[[nodiscard]] double octagon_radius_m(double side_m);

/// Eight receivers at the corners of a regular octagon, r0 on the vehicle's +x axis turned by turn_rad, the
/// rest counter-clockwise in steps of 45 degrees, each hearing outwards (Kleeman's array).
[[nodiscard]] std::vector<ArrayElement> octagon(double side_m, double height_m, double turn_rad = 0.0);

}  // namespace octant
