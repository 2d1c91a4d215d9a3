// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/floor_grid.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "models/physics/polygon.h"

namespace octant::survey {
namespace {

constexpr std::size_t kBlockColumns = 32, kBlockRows = 16;

/// Marks the cells of a grid whose centres lie within a polygon: row by row between the outline's crossings.
void mark_inside(const Polygon& polygon, const FloorGrid& grid, std::uint8_t value,
                 std::vector<std::uint8_t>& mask) {
  std::vector<double> crossings;
  const Eigen::AlignedBox2d box = bounds_of(polygon);
  const auto row_of = [&](double y) {
    return static_cast<std::size_t>(
        std::clamp((y - grid.origin_m.y()) / grid.cell_m, 0.0, static_cast<double>(grid.rows)));
  };
  for (std::size_t row = row_of(box.min().y()); row < std::min(grid.rows, row_of(box.max().y()) + 1); ++row) {
    const double y = grid.origin_m.y() + grid.cell_m * (static_cast<double>(row) + 0.5);
    crossings.clear();
    for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
      const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
      if ((a.y() > y) != (b.y() > y))
        crossings.push_back((b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()) + a.x());
    }
    std::ranges::sort(crossings);
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
      const auto column = [&](double x) {  // first one with its centre beyond x
        return static_cast<std::size_t>(std::clamp(std::ceil((x - grid.origin_m.x()) / grid.cell_m - 0.5),
                                                   0.0, static_cast<double>(grid.columns)));
      };
      const auto begin = mask.begin() + static_cast<std::ptrdiff_t>(row * grid.columns);
      std::fill(begin + static_cast<std::ptrdiff_t>(column(crossings[k])),
                begin + static_cast<std::ptrdiff_t>(column(crossings[k + 1])), value);
    }
  }
}

}  // namespace

Result<FloorGrid> make_floor_grid(const SurveyModel& model, const Scene& scene) {
  return make_floor_grid(model, scene, scene.cell_m);
}

Result<FloorGrid> make_floor_grid(const SurveyModel& model, const Scene& scene, double cell_m) {
  const Eigen::AlignedBox2d box = bounds_of(model.floor_m);
  const Eigen::Vector2d size = box.sizes();
  FloorGrid grid;
  grid.cell_m = cell_m;
  grid.origin_m = box.min();
  const double columns = std::max(1.0, std::ceil(size.x() / cell_m - 1e-9)),
               rows = std::max(1.0, std::ceil(size.y() / cell_m - 1e-9));
  if (!(columns * rows <= kMostCells)) {
    return fail(
        {.file = scene.path,
         .line = scene.cell_line,
         .found = fmt::format("cell_m of {:g} m makes {:.3g} cells of the floor's {:.6g} x {:.6g} m", cell_m,
                              columns * rows, size.x(), size.y()),
         .expected = fmt::format("{:.3g} cells at most", kMostCells),
         .advice = fmt::format("a cell_m of {:.2g} would do", 1.05 * std::sqrt(size.prod() / kMostCells))});
  }
  grid.columns = static_cast<std::size_t>(columns), grid.rows = static_cast<std::size_t>(rows);
  std::vector<std::uint8_t> mask(grid.columns * grid.rows, 0);
  mark_inside(model.floor_m, grid, 1, mask);
  for (const SceneWall& wall : scene.walls)
    if (wall.solid && wall.blocks_vehicle) mark_inside(wall.points_m, grid, 0, mask);
  grid.cells.reserve(static_cast<std::size_t>(std::ranges::count(mask, 1)));
  for (std::size_t block_row = 0; block_row < grid.rows; block_row += kBlockRows)
    for (std::size_t block = 0; block < grid.columns; block += kBlockColumns)
      for (std::size_t row = block_row; row < std::min(grid.rows, block_row + kBlockRows); ++row)
        for (std::size_t column = block; column < std::min(grid.columns, block + kBlockColumns); ++column)
          if (mask[row * grid.columns + column] != 0)
            grid.cells.push_back(static_cast<std::uint32_t>(row * grid.columns + column));
  if (grid.cells.empty())
    return fail({.file = scene.path,
                 .line = scene.floor_line,
                 .found = "not a single cell of the floor is free",
                 .expected = "a floor larger than a cell",
                 .advice = "a smaller cell_m, or obstacles that leave room"});
  return grid;
}

PoseList poses_of(const FloorGrid& grid, double heading_rad, double z_m, std::size_t first,
                  std::size_t count) {
  PoseList poses;
  for (auto* list : {&poses.x_m, &poses.y_m, &poses.z_m, &poses.heading_rad}) list->reserve(count);
  for (std::size_t i = first; i < std::min(first + count, grid.cells.size()); ++i) {
    const Eigen::Vector2d centre = grid.centre_m(grid.cells[i]);
    poses.add(centre.x(), centre.y(), z_m, heading_rad);
  }
  return poses;
}

double most_poses_along(const SceneRoute& route, double step_m) {
  double count = 1.0;
  for (std::size_t i = 1; i < route.points_m.size(); ++i)
    count += (route.points_m[i] - route.points_m[i - 1]).norm() / step_m + 1.0;
  return count;
}

PoseList poses_along(const SceneRoute& route, double step_m, double z_m) {
  PoseList poses;
  for (std::size_t i = 1; i < route.points_m.size(); ++i) {
    const Eigen::Vector2d from = route.points_m[i - 1], along = route.points_m[i] - from;
    const double heading = std::atan2(along.y(), along.x());
    const double steps = std::max(1.0, std::ceil(along.norm() / step_m - 1e-9));
    for (double k = i == 1 ? 0.0 : 1.0; k <= steps; ++k) {
      const Eigen::Vector2d p = from + along * (k / steps);
      poses.add(p.x(), p.y(), z_m, heading);
    }
  }
  return poses;
}

}  // namespace octant::survey
