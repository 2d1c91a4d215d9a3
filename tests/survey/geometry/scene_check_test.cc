// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/scene_check.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace scene_check_test {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// The small hall with something of each kind, each on a line of its own.
Scene whole_scene() {
  Scene scene = test::small_scene();
  scene.path = "hall.yaml";
  scene.cell_line = 2, scene.floor_line = 3;
  scene.walls[0].line = 4, scene.walls[1].line = 5;
  scene.routes[0].line = 6;
  SceneMount wall{
      .name = "south", .points_m = {{0, 0}, {12, 0}}, .low_m = 2.0, .high_m = 3.0, .axis = {}, .line = 7};
  SceneMount pole{.name = "pole",
                  .kind = SceneMount::Kind::kPole,
                  .points_m = {{2, 2}},
                  .low_m = 1.0,
                  .high_m = 2.0,
                  .axis = {},
                  .line = 8};
  SceneMount ceiling{.name = "ceiling",
                     .kind = SceneMount::Kind::kCeiling,
                     .points_m = {{0, 0}, {4, 0}, {4, 4}},
                     .low_m = 5.0,
                     .high_m = 5.0,
                     .axis = {},
                     .line = 9};
  scene.mounts = {wall, pole, ceiling};
  BeamPattern cone;
  cone.name = "cone", cone.line = 10;
  BeamPattern table;
  table.name = "table", table.line = 11, table.kind = BeamPattern::Kind::kTable;
  table.angle_rad = {0.0, 0.5, 1.0}, table.gain = {1.0, 0.5, 0.0};
  scene.patterns = {cone, table};
  return scene;
}

void expect_bad(void (*change)(Scene&), int line, const std::string& words) {
  Scene scene = whole_scene();
  change(scene);
  const auto checked = check_scene(scene);
  ASSERT_FALSE(checked) << "accepted: " << words;
  EXPECT_EQ(checked.error().line, line) << checked.error().message();
  EXPECT_EQ(checked.error().file, "hall.yaml");
  EXPECT_THAT(checked.error().message(), HasSubstr(words));
  EXPECT_NE(checked.error().expected, "") << words;
}

TEST(SceneCheck, AWholeSceneAndAnEmptyOneAreFine) {
  EXPECT_TRUE(check_scene(whole_scene()));
  EXPECT_TRUE(check_scene(Scene{}));
}

TEST(SceneCheck, CellsHaveASize) {
  for (const auto change : {+[](Scene& s) { s.cell_m = 0.0; }, +[](Scene& s) { s.cell_m = -1.0; },
                            +[](Scene& s) { s.cell_m = kNan; }, +[](Scene& s) { s.cell_m = kInf; }})
    expect_bad(change, 2, "cell_m");
}

TEST(SceneCheck, FloorsAreOutlines) {
  expect_bad([](Scene& s) { s.floor_m.pop_back(), s.floor_m.pop_back(); }, 3, "the floor has 2 corners");
  expect_bad([](Scene& s) { s.floor_m[1].x() = kNan; }, 3, "no finite number");
  expect_bad([](Scene& s) { s.floor_m[1].y() = kInf; }, 3, "no finite number");
  expect_bad([](Scene& s) { std::swap(s.floor_m[1], s.floor_m[2]); }, 3, "crosses itself: the side from");
  expect_bad([](Scene& s) { s.floor_m.push_back(s.floor_m[0]); }, 3,
             "the floor has the corner (0, 0) twice in a row, at its end and its begin");
  expect_bad([](Scene& s) { s.floor_m.insert(s.floor_m.begin() + 1, s.floor_m[1]); }, 3, "twice in a row");
  expect_bad(
      [](Scene& s) {
        for (Eigen::Vector2d& p : s.floor_m) p += Eigen::Vector2d(500000, 5700000);
        std::swap(s.floor_m[1], s.floor_m[2]);
      },
      3, "(500012, 5700008)");
  expect_bad([](Scene& s) { s.floor_m.assign(20001, Eigen::Vector2d(1, 1)); }, 3, "20000 at most");
}

TEST(SceneCheck, WallsHaveLengthAndHeight) {
  expect_bad([](Scene& s) { s.walls[1].points_m.resize(1); }, 5, "wall 'curtain' has 1 points");
  expect_bad([](Scene& s) { s.walls[1].points_m[1] = s.walls[1].points_m[0]; }, 5, "twice in a row");
  expect_bad([](Scene& s) { s.walls[1].points_m[0].x() = kNan; }, 5, "no finite number");
  expect_bad([](Scene& s) { s.walls[1].top_m = 0.0; }, 5, "ends at 0 m, below its begin at 0 m");
  expect_bad([](Scene& s) { s.walls[1].bottom_m = kNan; }, 5, "wall 'curtain'");
  expect_bad([](Scene& s) { s.walls[0].points_m.resize(2); }, 4, "obstacle 'column' has 2 corners");
  expect_bad([](Scene& s) { std::swap(s.walls[0].points_m[1], s.walls[0].points_m[2]); }, 4,
             "obstacle 'column' crosses itself");
}

TEST(SceneCheck, MountsAreSomewhere) {
  expect_bad([](Scene& s) { s.mounts[0].points_m.resize(1); }, 7, "mount 'south' has 1 points");
  expect_bad([](Scene& s) { s.mounts[1].points_m.emplace_back(3, 3); }, 8, "mount 'pole' is a pole");
  expect_bad([](Scene& s) { s.mounts[1].points_m[0].x() = kNan; }, 8, "mount 'pole'");
  expect_bad([](Scene& s) { s.mounts[2].points_m.resize(2); }, 9, "mount 'ceiling' has 2 corners");
  expect_bad([](Scene& s) { s.mounts[0].low_m = 3.5; }, 7, "from 3.5 m down to 3 m");
  expect_bad([](Scene& s) { s.mounts[0].high_m = kNan; }, 7, "mount 'south'");
}

TEST(SceneCheck, MountsHaveFiniteHeights) {
  expect_bad([](Scene& s) { s.mounts[0].high_m = kInf; }, 7, "mount 'south'");
  expect_bad([](Scene& s) { s.mounts[1].low_m = -kInf; }, 8, "mount 'pole'");
}

TEST(SceneCheck, PatternsHearSomething) {
  expect_bad([](Scene& s) { s.patterns[0].half_angle_rad = 0.0; }, 10, "pattern 'cone' hears nothing");
  expect_bad([](Scene& s) { s.patterns[0].half_angle_rad = kNan; }, 10, "pattern 'cone' hears nothing");
  expect_bad([](Scene& s) { s.patterns[0].exponent = -1.0; }, 10, "negative exponent");
  expect_bad([](Scene& s) { s.patterns[1].gain.pop_back(); }, 11, "3 angles and 2 gains");
  expect_bad([](Scene& s) { s.patterns[1].gain[1] = 1.5; }, 11, "a gain of 1.5");
  expect_bad([](Scene& s) { s.patterns[1].gain[1] = kNan; }, 11, "a gain of nan");
  expect_bad([](Scene& s) { s.patterns[1].angle_rad[0] = 0.1; }, 11, "out of order");
  expect_bad([](Scene& s) { s.patterns[1].angle_rad[2] = 0.5; }, 11, "out of order");
}

TEST(SceneCheck, RoutesStayWhereVehiclesCanBe) {
  expect_bad([](Scene& s) { s.routes[0].points_m[1].x() = 12.5; }, 6, "leaves the floor at (12.5, 1)");
  expect_bad([](Scene& s) { s.routes[0].points_m[1] = {6, 4}; }, 6, "runs through obstacle 'column'");
  expect_bad([](Scene& s) { s.routes[0].points_m.resize(1); }, 6, "route 'way' has 1 points");
  Scene scene = whole_scene();
  scene.routes[0].points_m[1] = {12, 1};  // on the outline
  EXPECT_TRUE(check_scene(scene));
  scene.routes[0].points_m[1] = {5, 4};  // along the column's face
  EXPECT_TRUE(check_scene(scene));
  scene.floor_m.clear();  // it is taken from the beacons later
  scene.routes[0].points_m[1] = {100, 1};
  EXPECT_TRUE(check_scene(scene));
}

/// A duct under the ceiling stops sound, but not vehicles.
TEST(SceneCheck, RoutesLeadUnderWhatDoesNotBlockVehicles) {
  Scene scene = whole_scene();
  scene.walls[0].blocks_vehicle = false;
  scene.walls[0].bottom_m = 3.0;
  scene.routes[0].points_m[1] = {6, 4};
  const auto checked = check_scene(scene);
  EXPECT_TRUE(checked) << checked.error().message();
}

/// One beacon at a place, known to sigma_m.
Result<void> place_check(const Scene& scene, const Eigen::Vector3d& p_map_m, double sigma_m) {
  SurveyModel model;
  model.beacons = {{"B0", p_map_m}};
  return check_beacon_places(scene, model, {sigma_m});
}

TEST(SceneCheck, BeaconsHangWithinTheFloorGiveOrTakeATape) {
  const Scene scene = whole_scene();
  EXPECT_TRUE(place_check(scene, {1, 1, 2}, 0.0));
  EXPECT_TRUE(place_check(scene, {-kOutside_m + 1e-9, 1, 2}, 0.0));
  EXPECT_FALSE(place_check(scene, {-kOutside_m - 1e-3, 1, 2}, 0.0));
  EXPECT_TRUE(place_check(scene, {-kOutside_m - 0.29, 1, 2}, 0.1)) << "three sigmas are allowed for";
  EXPECT_FALSE(place_check(scene, {-kOutside_m - 0.31, 1, 2}, 0.1));
  const auto error = place_check(scene, {-2, 1, 2}, 0.0);
  ASSERT_FALSE(error);
  EXPECT_THAT(error.error().message(), HasSubstr("beacon 'B0' at (-2, 1) is 2.00 m outside the floor"));
  Scene open = scene;
  open.floor_m.clear();
  EXPECT_TRUE(place_check(open, {-200, 1, 2}, 0.0)) << "without an outline nothing is outside";
}

TEST(SceneCheck, BeaconsHangOnFacesAndAboveObstaclesNotWithin) {
  Scene scene = whole_scene();
  scene.walls[0].top_m = 2.0;
  EXPECT_TRUE(place_check(scene, {5.0005, 4, 1}, 0.0)) << "on its face";
  EXPECT_FALSE(place_check(scene, {5.1, 4, 1}, 0.0));
  EXPECT_TRUE(place_check(scene, {5.1, 4, 1}, 0.04)) << "its place is known to four centimetres";
  EXPECT_TRUE(place_check(scene, {6, 4, 2.5}, 0.0)) << "above it";
  scene.walls[0].slack_m = 0.2;
  EXPECT_TRUE(place_check(scene, {5.1, 4, 1}, 0.0)) << "half a pixel of a map";
  const auto error = place_check(scene, {6, 4, 1}, 0.0);
  ASSERT_FALSE(error);
  EXPECT_THAT(error.error().message(), HasSubstr("beacon 'B0' at (6, 4) is 1.00 m inside obstacle 'column'"));
  EXPECT_EQ(error.error().line, 4) << "the obstacle's, where the scene says nothing of the beacon";
  scene.beacons = {{"B0", {}, {}, 12}};
  EXPECT_EQ(place_check(scene, {6, 4, 1}, 0.0).error().line, 12);
}

}  // namespace scene_check_test
}  // namespace octant::survey
