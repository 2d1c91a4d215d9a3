// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/floor_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/physics/polygon.h"
#include "models/simulator/random.h"
#include "tests/support/worlds.h"

namespace octant::survey {
namespace floor_grid_test {

using test::must;
using ::testing::HasSubstr;

/// A star round a middle: never crosses itself, and is as ragged as the draws are.
Polygon some_star(Random& draws, const Eigen::Vector2d& middle, double size_m, int corners) {
  Polygon star;
  for (int i = 0; i < corners; ++i) {
    const double turn = 2 * std::numbers::pi * (i + draws.uniform(0, 0.9)) / corners;
    star.emplace_back(middle +
                      size_m * draws.uniform(0.3, 1) * Eigen::Vector2d(std::cos(turn), std::sin(turn)));
  }
  return star;
}

SceneWall obstacle(const Polygon& outline) {
  SceneWall wall;
  wall.points_m = outline;
  wall.solid = true;
  return wall;
}

TEST(FloorGrid, CellsAreThoseWhoseMiddleIsOnTheFloorAndInNothing) {
  Random draws(20261125);
  for (int world = 0; world < 40; ++world) {
    SurveyModel model;
    model.floor_m = some_star(draws, {draws.uniform(-50, 50), draws.uniform(-50, 50)}, 10, 5 + world % 9);
    Scene scene;
    scene.cell_m = draws.uniform(0.15, 0.9);
    const Eigen::Vector2d middle = model.floor_m.front();
    scene.walls = {obstacle(some_star(draws, middle, 4, 6)), obstacle(some_star(draws, middle, 5, 5))};
    scene.walls[1].blocks_vehicle = false;
    SceneWall curtain;
    curtain.points_m = some_star(draws, middle, 4, 6);
    scene.walls.push_back(curtain);  // a line has no inside
    const FloorGrid grid = must(make_floor_grid(model, scene));
    const std::set<std::uint32_t> cells(grid.cells.begin(), grid.cells.end());
    EXPECT_EQ(cells.size(), grid.cells.size()) << "each once";
    for (std::uint32_t cell = 0; cell < grid.columns * grid.rows; ++cell) {
      const Eigen::Vector2d p = grid.centre_m(cell);
      EXPECT_EQ(cells.contains(cell), is_inside(model.floor_m, p) && !is_inside(scene.walls[0].points_m, p))
          << world << ": " << p.transpose();
    }
  }
}

TEST(FloorGrid, ACellBeyondEitherEdgeWouldBeNone) {
  SurveyModel model;
  model.floor_m = {{1, 2}, {4, 2}, {4, 3}, {1, 3}};
  Scene scene;
  scene.cell_m = 0.5;  // three metres are six cells, not seven
  const FloorGrid grid = must(make_floor_grid(model, scene));
  EXPECT_EQ(grid.columns, 6U);
  EXPECT_EQ(grid.rows, 2U);
  EXPECT_EQ(grid.cells.size(), 12U);
  EXPECT_EQ(grid.centre_m(0), Eigen::Vector2d(1.25, 2.25));
  EXPECT_EQ(grid.centre_m(11), Eigen::Vector2d(3.75, 2.75));
  EXPECT_EQ(must(make_floor_grid(model, scene, 0.7)).columns, 5U) << "the last one reaches over the edge";
  EXPECT_FALSE(make_floor_grid(model, scene, 30.0)) << "a cell whose middle is beyond the floor";
}

TEST(FloorGrid, NeighboursInTheListAreNeighboursOnTheFloor) {
  SurveyModel model;
  model.floor_m = {{0, 0}, {40, 0}, {40, 20}, {0, 20}};
  Scene scene;
  scene.cell_m = 0.25;
  const FloorGrid grid = must(make_floor_grid(model, scene));
  // Row by row 512 cells would be a strip of 40 m; a block is 32 by 16 cells, 8 m by 4 m.
  for (std::size_t first = 0; first + 512 <= grid.cells.size(); first += 512) {
    Eigen::Vector2d low = grid.centre_m(grid.cells[first]), high = low;
    for (std::size_t i = first; i < first + 512; ++i)
      low = low.cwiseMin(grid.centre_m(grid.cells[i])), high = high.cwiseMax(grid.centre_m(grid.cells[i]));
    EXPECT_LT((high - low).maxCoeff(), 8.0);
  }
}

TEST(FloorGrid, TooManyCellsAreRefusedBeforeTheyAreMade) {
  SurveyModel model;
  model.floor_m = {{0, 0}, {1e6, 0}, {1e6, 1e6}, {0, 1e6}};
  Scene scene;
  scene.path = "hall.yaml", scene.cell_line = 7;
  scene.cell_m = 1.0;
  const auto grid = make_floor_grid(model, scene);
  ASSERT_FALSE(grid);
  EXPECT_EQ(grid.error().line, 7);
  EXPECT_THAT(grid.error().message(), HasSubstr("makes 1e+12 cells"));
  // Its advice works.
  const std::string& advice = grid.error().advice;
  EXPECT_THAT(advice, HasSubstr("a cell_m of "));
  EXPECT_TRUE(make_floor_grid(model, scene, std::stod(advice.substr(12))));
}

TEST(FloorGrid, NoFreeCellIsAnError) {
  SurveyModel model;
  model.floor_m = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  Scene scene;
  scene.floor_line = 3;
  scene.walls = {obstacle({{-1, -1}, {5, -1}, {5, 5}, {-1, 5}})};
  const auto grid = make_floor_grid(model, scene);
  ASSERT_FALSE(grid);
  EXPECT_EQ(grid.error().line, 3);
  EXPECT_THAT(grid.error().message(), HasSubstr("not a single cell of the floor is free"));
}

TEST(FloorGrid, PosesAreTheMiddlesOfCells) {
  SurveyModel model;
  model.floor_m = {{0, 0}, {3, 0}, {3, 2}, {0, 2}};
  const FloorGrid grid = must(make_floor_grid(model, Scene{}, 1.0));
  const PoseList all = poses_of(grid, 0.5, 0.25), some = poses_of(grid, 0.5, 0.25, 4, 100);
  ASSERT_EQ(all.size(), 6U);
  ASSERT_EQ(some.size(), 2U) << "as many as there are";
  EXPECT_EQ(some.x_m[0], all.x_m[4]);
  EXPECT_EQ(some.y_m[1], all.y_m[5]);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(Eigen::Vector2d(all.x_m[i], all.y_m[i]), grid.centre_m(grid.cells[i]));
    EXPECT_EQ(all.z_m[i], 0.25);
    EXPECT_EQ(all.heading_rad[i], 0.5);
  }
}

TEST(FloorGrid, PosesAlongARouteAreAStepApartAndLookAhead) {
  Random draws(3);
  for (int trial = 0; trial < 200; ++trial) {
    SceneRoute route;
    const int corners = 2 + trial % 5;
    for (int i = 0; i < corners; ++i) route.points_m.emplace_back(draws.uniform(0, 30), draws.uniform(0, 30));
    const double step_m = draws.log_uniform(0.05, 40);
    const PoseList poses = poses_along(route, step_m, 0.5);
    EXPECT_LE(static_cast<double>(poses.size()), most_poses_along(route, step_m));
    std::size_t corner = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector2d p(poses.x_m[i], poses.y_m[i]);
      EXPECT_EQ(poses.z_m[i], 0.5);
      if (i > 0) {
        const Eigen::Vector2d way = p - Eigen::Vector2d(poses.x_m[i - 1], poses.y_m[i - 1]);
        EXPECT_LE(way.norm(), step_m * (1 + 1e-9));
        // Each looks along the side that leads to it.
        EXPECT_NEAR(std::remainder(std::atan2(way.y(), way.x()) - poses.heading_rad[i], 2 * M_PI), 0, 1e-6);
      }
      if (corner < route.points_m.size() && (p - route.points_m[corner]).norm() < 1e-12) ++corner;
    }
    EXPECT_EQ(corner, route.points_m.size()) << "all corners are among them, in their order";
  }
}

TEST(FloorGrid, ARouteOfWholeStepsHasNoneMore) {
  const SceneRoute route{"way", {{0, 0}, {3, 0}, {3, 0.3}}};
  EXPECT_EQ(poses_along(route, 0.1).size(), 1U + 30U + 3U);
}

}  // namespace floor_grid_test
}  // namespace octant::survey
