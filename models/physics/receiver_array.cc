// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/receiver_array.h"

#include <cmath>

namespace octant {

double octagon_radius_m(double side_m) { return side_m / (2 * std::sin(M_PI / 8)); }

std::vector<ArrayElement> octagon(double side_m, double height_m, double turn_rad) {
  const double radius_m = octagon_radius_m(side_m);
  std::vector<ArrayElement> corners;
  for (int i = 0; i < 8; ++i) {
    const double angle = turn_rad + i * M_PI / 4;
    const Eigen::Vector3d axis(std::cos(angle), std::sin(angle), 0.0);
    corners.push_back({radius_m * axis + Eigen::Vector3d(0, 0, height_m), axis});
  }
  return corners;
}

}  // namespace octant
