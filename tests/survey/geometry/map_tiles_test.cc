// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Exclusions of a tile must have no effect: compared with every wall and every beacon, one path at a time.
#include "survey/geometry/map_tiles.h"

#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/survey/brute_force.h"

namespace octant::survey {
namespace map_tiles_test {

SurveyModel model_of(const std::vector<Eigen::Vector3d>& levers) {
  SurveyModel model;
  for (const auto& lever : levers) model.receivers.push_back({"r", lever});
  model.unknowns = unknowns_of(model.motion, model.clock, model.receivers);
  model.noise.constant_m = 0.01;
  return model;
}

WallPiece some_wall(Random& draws) {
  WallPiece wall;
  wall.from_m = {draws.uniform(0, 20), draws.uniform(0, 20)};
  const double turn = draws.uniform(0, 2 * std::numbers::pi), length_m = draws.log_uniform(0.3, 15);
  wall.to_m = wall.from_m + length_m * Eigen::Vector2d(std::cos(turn), std::sin(turn));
  if (draws.uniform() < 0.5) wall.bottom_m = draws.uniform(0, 2), wall.top_m = draws.uniform(1, 4);
  if (wall.top_m < wall.bottom_m) std::swap(wall.top_m, wall.bottom_m);
  return wall;
}

PoseList some_cluster(Random& draws, std::size_t count, double width_m) {
  PoseList poses;
  const double x = draws.uniform(0, 20), y = draws.uniform(0, 20), z = draws.uniform(0, 1);
  for (std::size_t i = 0; i < count; ++i)
    poses.add(x + draws.uniform(0, width_m), y + draws.uniform(0, width_m), z + draws.uniform(0, 0.1),
              draws.uniform(-3, 3));
  return poses;
}

std::unique_ptr<KernelTile> tile_of(const KernelModel& kernel, const std::vector<WallPiece>& walls,
                                    const PoseList& poses) {
  auto tile = std::make_unique<KernelTile>();
  fill_tile(kernel, walls, poses, 0, poses.size(), *tile);
  return tile;
}

bool hidden_by(const KernelTile& tile, std::size_t b, const Eigen::Vector3d& from,
               const Eigen::Vector3d& to) {
  for (std::uint32_t w = tile.wall_first[b]; w < tile.wall_first[b + 1]; ++w) {
    const KernelWall& k = tile.walls[w];
    WallPiece wall{{k.x_m, k.y_m}, {k.x_m + k.wx_m, k.y_m + k.wy_m}, k.bottom_m, k.top_m};
    // If it is marked as higher than all paths, its heights must not matter.
    if (k.any_height) wall.bottom_m = -1e9, wall.top_m = 1e9;
    if (test::crosses(wall, from, to)) return true;
  }
  return false;
}

struct Count {
  int left_out = 0, kept = 0, skipped = 0, hidden = 0, heard = 0;
};

void compare(const SurveyModel& model, const PoseList& poses, Count& count) {
  const KernelModel kernel = kernel_model(model, model.beacons);
  const auto tile = tile_of(kernel, model.walls, poses);
  ASSERT_EQ(tile->wall_first.size(), model.beacons.size() + 1);
  for (std::size_t b = 0; b < model.beacons.size(); ++b) {
    count.kept += static_cast<int>(tile->wall_first[b + 1] - tile->wall_first[b]);
    count.left_out += static_cast<int>(model.walls.size() - (tile->wall_first[b + 1] - tile->wall_first[b]));
    count.skipped += tile->skip[b];
    for (std::size_t i = 0; i < poses.size(); ++i)
      for (const SurveyReceiver& r : model.receivers) {
        const Eigen::Matrix3d R =
            Eigen::AngleAxisd(poses.heading_rad[i], Eigen::Vector3d::UnitZ()).toRotationMatrix();
        const Eigen::Vector3d at =
            Eigen::Vector3d(poses.x_m[i], poses.y_m[i], poses.z_m[i]) + R * r.p_vehicle_m;
        const Eigen::Vector3d& beacon = model.beacons[b].p_map_m;
        bool hidden = false;
        for (const WallPiece& wall : model.walls) hidden = hidden || test::crosses(wall, at, beacon);
        const bool heard = !hidden && (at - beacon).norm() <= model.hearing.range_m;
        if (tile->skip[b] != 0)
          EXPECT_FALSE(heard) << "a beacon that is heard is skipped";
        else
          EXPECT_EQ(hidden_by(*tile, b, at, beacon), hidden) << "a wall that matters is left out";
        ++(heard ? count.heard : count.hidden);
      }
  }
}

TEST(MapTiles, WallsThatAreLeftOutDoNotMatter) {
  Random draws(20261125);
  Count count;
  for (int world = 0; world < 400; ++world) {
    SurveyModel model = model_of(
        {{0, 0, 0.3}, {draws.uniform(-0.5, 0.5), draws.uniform(-0.5, 0.5), draws.uniform(0.2, 1.5)}});
    model.hearing.range_m = draws.uniform(5, 25);
    for (int w = 0; w < 12; ++w) model.walls.push_back(some_wall(draws));
    for (int b = 0; b < 6; ++b) {
      Eigen::Vector2d at(draws.uniform(0, 20), draws.uniform(0, 20));
      if (b % 2 == 0) {  // as mounted: a hand before a wall, on either side
        const WallPiece& wall = model.walls[static_cast<std::size_t>(b)];
        const Eigen::Vector2d along = wall.to_m - wall.from_m;
        at = wall.from_m + draws.uniform() * along +
             draws.uniform(-0.1, 0.1) * Eigen::Vector2d(-along.y(), along.x()).normalized();
      }
      model.beacons.push_back({"B", {at.x(), at.y(), draws.uniform(0.5, 4)}});
    }
    compare(model, some_cluster(draws, 9, draws.log_uniform(0.05, 4)), count);
  }
  // Otherwise the test is empty.
  EXPECT_GT(count.left_out, 4 * count.kept) << "most walls are elsewhere";
  EXPECT_GT(count.kept, 1000);
  EXPECT_GT(count.skipped, 400);
  EXPECT_GT(count.heard, 1000);
  EXPECT_GT(count.hidden, 1000);
}

TEST(MapTiles, OneWallBeforeAllOfThemSavesTheBeacon) {
  SurveyModel model = model_of({{0, 0, 0.5}});
  model.beacons = {{"B0", {10, 5, 2}}};
  model.walls = {{{5, 0}, {5, 10}, 0.0, 3.0}};
  PoseList poses;
  for (int i = 0; i < 5; ++i) poses.add(1, 4 + 0.2 * i, 0, 0);
  const KernelModel kernel = kernel_model(model, model.beacons);
  EXPECT_EQ(tile_of(kernel, model.walls, poses)->skip[0], 1);
  model.walls[0].top_m = 1.0;  // the path crosses it at 1.17 m
  EXPECT_EQ(tile_of(kernel, model.walls, poses)->skip[0], 0);
  model.walls[0] = {{5, 0}, {5, 4.5}};  // beside some of them
  EXPECT_EQ(tile_of(kernel, model.walls, poses)->skip[0], 0);
}

TEST(MapTiles, ABeaconOutOfReachOfAllIsSkipped) {
  SurveyModel model = model_of({{0.5, 0, 0}});
  model.beacons = {{"B0", {10, 0, 0}}};
  PoseList poses;
  poses.add(0, 0, 0, 0), poses.add(1, 0, 0, std::numbers::pi);
  // The nearest receiver may be half a metre nearer than the nearest vehicle.
  model.hearing.range_m = 8.6;
  EXPECT_EQ(tile_of(kernel_model(model, model.beacons), {}, poses)->skip[0], 0);
  model.hearing.range_m = 8.4;
  EXPECT_EQ(tile_of(kernel_model(model, model.beacons), {}, poses)->skip[0], 1);
}

TEST(MapTiles, LanesBehindTheLastPoseRepeatIt) {
  const SurveyModel model = model_of({{0, 0, 0}});
  PoseList poses;
  for (int i = 0; i < 11; ++i) poses.add(i, 2 * i, 3 * i, 0.1 * i);
  auto tile = std::make_unique<KernelTile>();
  fill_tile(kernel_model(model, {}), {}, poses, 2, 9, *tile);
  EXPECT_EQ(tile->count, 9U);
  for (std::size_t i = 0; i < 16; ++i) {
    const double n = 2.0 + static_cast<double>(std::min<std::size_t>(i, 8));
    EXPECT_EQ(tile->x_m[i], n);
    EXPECT_EQ(tile->y_m[i], 2 * n);
    EXPECT_EQ(tile->z_m[i], 3 * n);
    // One angle as a product and as a sum of steps may differ in the last digit.
    EXPECT_NEAR(std::atan2(tile->sine[i], tile->cosine[i]), 0.1 * n, 1e-15);
  }
}

TEST(MapTiles, PatternsBecomeAnEdgeAndATable) {
  SurveyModel model = model_of({{0, 0, 0}});
  BeamPattern cone, wide, power;
  cone.half_angle_rad = 0.7;
  wide.half_angle_rad = 3.2;
  power.kind = BeamPattern::Kind::kCosinePower, power.exponent = 2.0, power.half_angle_rad = 2.0;
  model.patterns = {cone, wide, power};
  const Eigen::Vector3d down(0, 0, -1);
  model.beacons = {{"cone", {0, 0, 3}, down, 0},
                   {"wide", {0, 0, 3}, down, 1},
                   {"power", {0, 0, 3}, down, 2},
                   {"round", {0, 0, 3}, Eigen::Vector3d::Zero(), 0}};
  const KernelModel kernel = kernel_model(model, model.beacons);
  EXPECT_DOUBLE_EQ(kernel.beacons[0].least_cosine, std::cos(0.7));
  EXPECT_EQ(kernel.beacons[0].gain, nullptr) << "within a cone all is 1";
  EXPECT_LT(kernel.beacons[1].least_cosine, -1.0) << "all round";
  EXPECT_NEAR(kernel.beacons[2].least_cosine, 0.0, 1e-15) << "a cosine's power ends at the right angle";
  ASSERT_NE(kernel.beacons[2].gain, nullptr);
  for (std::size_t i = 0; i <= kGainSteps; i += 64) {
    const double cosine = -1.0 + 2.0 * static_cast<double>(i) / kGainSteps;
    EXPECT_NEAR(kernel.beacons[2].gain[i], cosine > 0 ? cosine * cosine : 0.0, 1e-14);
  }
  EXPECT_LT(kernel.beacons[3].least_cosine, -1.0) << "it looks nowhere";
}

}  // namespace map_tiles_test
}  // namespace octant::survey
