// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Core>

namespace octant::calib {

/// A place of the vehicle, within which errors are one and the same (reflections, cameras, bodies in the
/// way): arrivals that were recorded there are one piece of evidence, however many they are.
using Place = std::array<double, 3>;

/// Place at which the vehicle is: a cell of 5 % of the typical range.
/// @param p_map_m  where the vehicle is  @param typical_range_m  see Problem::typical_range_m
[[nodiscard]] inline Place place_at(const Eigen::Vector3d& p_map_m, double typical_range_m) {
  constexpr double kShareOfRange = 0.05;
  const Eigen::Vector3d cell = (p_map_m / (kShareOfRange * typical_range_m)).array().floor();
  return {cell.x(), cell.y(), cell.z()};
}

}  // namespace octant::calib
