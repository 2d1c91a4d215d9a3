// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "models/support/result.h"
#include "survey/geometry/geometry_map.h"

namespace octant::survey {

/// Square cells over the floor. Row 0 is the lowest (map y), columns go with x.
struct FloorGrid {
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< lower left corner of the first cell
  double cell_m = 0.25;
  std::size_t columns = 0, rows = 0;
  /// Cells whose centre is on the floor and in no obstacle (row * columns + column), block by block:
  /// consecutive cells are neighbours, so that the same walls matter to them.
  std::vector<std::uint32_t> cells;
  [[nodiscard]] Eigen::Vector2d centre_m(std::uint32_t cell) const {
    return origin_m + cell_m * Eigen::Vector2d(static_cast<double>(cell % columns) + 0.5,
                                               static_cast<double>(cell / columns) + 0.5);
  }
};

inline constexpr double kMostCells =
    4e6;  ///< cells of the rectangle around the floor; some 90 bytes each during a survey

/// Errors, before memory is allocated: more than kMostCells cells; no cell on the floor.
[[nodiscard]] Result<FloorGrid> make_floor_grid(const SurveyModel& model, const Scene& scene);
/// Builds the grid with another cell size, for a coarser evaluation.
[[nodiscard]] Result<FloorGrid> make_floor_grid(const SurveyModel& model, const Scene& scene, double cell_m);

/// Poses at the centres of cells [first, first + count).
[[nodiscard]] PoseList poses_of(const FloorGrid& grid, double heading_rad, double z_m, std::size_t first,
                                std::size_t count);
[[nodiscard]] inline PoseList poses_of(const FloorGrid& grid, double heading_rad, double z_m = 0.0) {
  return poses_of(grid, heading_rad, z_m, 0, grid.cells.size());
}

/// Upper bound of the number of poses_along(), which are at most a step apart and at the corners of the
/// route, with the heading along it.
[[nodiscard]] double most_poses_along(const SceneRoute& route, double step_m);
[[nodiscard]] PoseList poses_along(const SceneRoute& route, double step_m, double z_m = 0.0);

}  // namespace octant::survey
