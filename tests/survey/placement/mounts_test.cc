// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/placement/mounts.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace octant::survey {
namespace mounts_test {

using test::must;

SceneMount wall(const std::string& name, std::vector<Eigen::Vector2d> points, double low_m, double high_m) {
  return {.name = name, .points_m = std::move(points), .low_m = low_m, .high_m = high_m, .axis = {}};
}

/// Two walls of 6 and 3 m, a pole (which counts a metre) and a ceiling of 2 x 1 m (as the 6 m round it).
Scene mixed_scene() {
  Scene scene;
  scene.mounts = {wall("long", {{0, 0}, {6, 0}}, 2.0, 4.0), wall("short", {{6, 0}, {6, 3}}, 3.0, 3.0)};
  scene.mounts.push_back({.name = "pole",
                          .kind = SceneMount::Kind::kPole,
                          .points_m = {{3, 3}},
                          .low_m = 1.0,
                          .high_m = 2.0,
                          .axis = {}});
  scene.mounts.push_back({.name = "ceiling",
                          .kind = SceneMount::Kind::kCeiling,
                          .points_m = {{1, 1}, {3, 1}, {3, 2}, {1, 2}},
                          .low_m = 5.0,
                          .high_m = 5.0,
                          .axis = {}});
  return scene;
}

TEST(Mounts, EachHasItsShareByItsLength) {
  const MountSpace space = must(MountSpace::of(mixed_scene()));
  std::map<std::string, int> share;
  constexpr int kSteps = 16000;
  for (int i = 0; i < kSteps; ++i) ++share[space.mount_name({(i + 0.5) / kSteps, 0.5})];
  for (const auto& [name, length_m] :
       {std::pair{"long", 6.0}, {"short", 3.0}, {"pole", 1.0}, {"ceiling", 6.0}})
    EXPECT_NEAR(share[name], kSteps * length_m / 16.0, 1.0) << name;
  EXPECT_EQ(space.mount_name({0.0, 0}), "long");
  EXPECT_EQ(space.mount_name({1.0, 0}), "ceiling");
}

TEST(Mounts, OnAWallOneGoesEvenlyFromItsBeginToItsEndAndUp) {
  const MountSpace space = must(MountSpace::of(mixed_scene()));
  for (int i = 0; i <= 10; ++i)
    for (int k = 0; k <= 4; ++k) {
      const SurveyBeacon b = space.beacon({6.0 / 16 * i / 10 * (1 - 1e-15), k / 4.0});
      // Two centimetres to the left of the path, in its direction.
      EXPECT_LT((b.p_map_m - Eigen::Vector3d(0.6 * i, 0.02, 2.0 + 0.5 * k)).norm(), 1e-9) << i << " " << k;
      EXPECT_EQ(b.axis, Eigen::Vector3d(0, 1, 0));
    }
  const SurveyBeacon turned = space.beacon({7.5 / 16, 0.3});
  EXPECT_LT((turned.p_map_m - Eigen::Vector3d(5.98, 1.5, 3.0)).norm(), 1e-9);
  EXPECT_EQ(turned.axis, Eigen::Vector3d(-1, 0, 0));
}

TEST(Mounts, UnderACeilingBothNumbersArePlaces) {
  const MountSpace space = must(MountSpace::of(mixed_scene()));
  for (const double part : {0.1, 0.5, 0.9})
    for (const double across : {0.0, 0.25, 1.0}) {
      const SurveyBeacon b = space.beacon({(10 + 6 * part) / 16, across});
      EXPECT_LT((b.p_map_m - Eigen::Vector3d(1 + 2 * part, 1 + across, 5.0)).norm(), 1e-9);
      EXPECT_EQ(b.axis, Eigen::Vector3d(0, 0, -1));
    }
}

TEST(Mounts, NumbersBeyondTheSquareAreItsEdge) {
  const MountSpace space = must(MountSpace::of(mixed_scene()));
  EXPECT_EQ(space.beacon({-0.5, -1}).p_map_m, space.beacon({0, 0}).p_map_m);
  EXPECT_EQ(space.beacon({1.5, 7}).p_map_m, space.beacon({1, 1}).p_map_m);
}

TEST(Mounts, AStatedAxisGoesBeforeTheUsualOne) {
  Scene scene = mixed_scene();
  scene.mounts[0].axis = Eigen::Vector3d(0, 3, -4);
  scene.patterns.resize(2);
  scene.beacon_pattern = 1;
  const MountSpace space = must(MountSpace::of(scene));
  EXPECT_LT((space.beacon({0.1, 0}).axis - Eigen::Vector3d(0, 0.6, -0.8)).norm(), 1e-15);
  EXPECT_EQ(space.beacon({0.1, 0}).pattern, 1U);
  EXPECT_EQ(space.beacon({9.5 / 16, 0}).pattern, kAllRound) << "a pole's looks nowhere";
}

TEST(Mounts, HeightsToChooseFromMakeItWide) {
  Scene scene;
  scene.mounts = {wall("flat", {{0, 0}, {6, 0}}, 3.0, 3.0)};
  EXPECT_FALSE(must(MountSpace::of(scene)).is_wide());
  scene.mounts[0].high_m = 3.5;
  EXPECT_TRUE(must(MountSpace::of(scene)).is_wide());
  EXPECT_TRUE(must(MountSpace::of(mixed_scene())).is_wide());
}

TEST(Mounts, TheGridHasThreeHeightsWhereThereIsAChoice) {
  const MountSpace space = must(MountSpace::of(mixed_scene()));
  std::map<std::string, std::map<double, int>> heights;
  for (const MountPoint& p : space.grid(32)) ++heights[space.mount_name(p)][space.beacon(p).p_map_m.z()];
  // Half a metre a place: twelve along the long wall, six along the short one.
  EXPECT_EQ(heights["long"], (std::map<double, int>{{2.0, 12}, {3.0, 12}, {4.0, 12}}));
  EXPECT_EQ(heights["short"], (std::map<double, int>{{3.0, 6}}));
  EXPECT_EQ(heights["pole"], (std::map<double, int>{{1.0, 1}, {1.5, 1}, {2.0, 1}}));
  // Twelve positions along the perimeter, in rows and columns over 2 x 1 m.
  EXPECT_NEAR(heights["ceiling"][5.0], 12, 3);
}

TEST(Mounts, RegularBeaconsStandAtEqualDistances) {
  Scene scene;
  // A square of 5 m round, counter-clockwise.
  scene.mounts = {wall("walls", {{0, 0}, {5, 0}, {5, 5}, {0, 5}, {0, 0}}, 2.0, 3.0)};
  const MountSpace space = must(MountSpace::of(scene));
  for (const double phase : {0.0, 0.3, 0.9}) {
    const auto points = space.regular(8, phase);
    std::vector<double> along;
    for (const MountPoint& p : points) {
      EXPECT_EQ(space.beacon(p).p_map_m.z(), 2.5) << "at half height";
      along.push_back(p.along);
    }
    std::sort(along.begin(), along.end());
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_NEAR(along[i], (static_cast<double>(i) + phase) / 8, 1e-12) << "an eighth of the way each";
  }
}

TEST(Mounts, UnderACeilingRegularBeaconsAreRowsAndColumns) {
  Scene scene;
  scene.mounts = {{.name = "ceiling",
                   .kind = SceneMount::Kind::kCeiling,
                   .points_m = {{0, 0}, {12, 0}, {12, 6}, {0, 6}},
                   .low_m = 5.0,
                   .high_m = 5.0,
                   .axis = {}}};
  const MountSpace space = must(MountSpace::of(scene));
  std::map<double, int> rows;
  for (const MountPoint& p : space.regular(8, 0.5)) ++rows[space.beacon(p).p_map_m.y()];
  EXPECT_EQ(rows, (std::map<double, int>{{1.5, 4}, {4.5, 4}})) << "twice as long as wide: two rows of four";
  rows.clear();
  for (const MountPoint& p : space.regular(9, 0.5)) ++rows[space.beacon(p).p_map_m.y()];
  int all = 0;
  for (const auto& [y, count] : rows) all += count;
  EXPECT_EQ(all, 9) << "none is lost where the number does not divide";
}

TEST(Mounts, NowhereToMountIsAnError) {
  Scene scene;
  scene.path = "hall.yaml";
  for (const bool a_point : {false, true}) {
    if (a_point) scene.mounts = {wall("point", {{1, 1}, {1, 1}}, 2.0, 3.0)};
    const auto space = MountSpace::of(scene);
    ASSERT_FALSE(space);
    EXPECT_THAT(space.error().message(), testing::HasSubstr("where beacons may be mounted"));
    EXPECT_EQ(space.error().file, "hall.yaml");
  }
}

}  // namespace mounts_test
}  // namespace octant::survey
