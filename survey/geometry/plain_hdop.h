// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace octant::survey {

/// Cells of a rectangle, centres a cell apart.
struct PlainGrid {
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< lower left corner
  double cell_m = 0.1;
  std::size_t columns = 0, rows = 0;
};

/// Horizontal dilution of one receiver at height z in planar motion with synchronised clocks, all beacons
/// heard everywhere: for a picture while one drags beacons about. In single precision: right to 1e-4 of the
/// value wherever it is below 100.
/// @return row by row from the lowest; infinity where it is beyond 1000
[[nodiscard]] std::vector<float> plain_hdop(const std::vector<Eigen::Vector3d>& beacons_m, double z_m,
                                            const PlainGrid& grid, int threads = 1);

}  // namespace octant::survey
