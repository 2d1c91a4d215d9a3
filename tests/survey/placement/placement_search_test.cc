// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Searches compared with all possible layouts, on few mounts.
#include "survey/placement/placement_search.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "survey/geometry/make_survey_model.h"
#include "survey/map/floor_grid.h"
#include "tests/survey/halls.h"

namespace octant::survey {
namespace placement_search_test {

using test::must;

/// Poles around a hall, at one height each: a layout is only a choice among them.
Scene poles_scene() {
  Scene scene = test::rectangle_hall().scene;
  scene.mounts.clear();
  const Eigen::Vector2d places[] = {{1, 1},   {8, 1},  {16, 1}, {23, 1}, {23, 13},
                                    {16, 13}, {8, 13}, {1, 13}, {12, 7}};
  for (const auto& p : places) {
    SceneMount pole;
    pole.name = "pole " + std::to_string(scene.mounts.size());
    pole.kind = SceneMount::Kind::kPole;
    pole.points_m = {p};
    pole.low_m = pole.high_m = 3.0;
    scene.mounts.push_back(pole);
  }
  return scene;
}

struct World {
  Scene scene = poles_scene();
  SurveyModel model = must(make_empty_survey_model(test::rectangle_hall().site, scene));
  MountSpace mounts = must(MountSpace::of(scene));
  LayoutScore score{model, poses_of(must(make_floor_grid(model, scene, 2.0)), 0.0), {}};
};

/// The middle of each pole's share.
std::vector<MountPoint> all_poles(const World& world) {
  std::vector<MountPoint> points;
  for (std::size_t i = 0; i < world.scene.mounts.size(); ++i)
    points.push_back({(static_cast<double>(i) + 0.5) / static_cast<double>(world.scene.mounts.size()), 0.5});
  return points;
}

double value_of(World& world, const std::vector<MountPoint>& layout, bool soft = false) {
  std::vector<SurveyBeacon> beacons;
  for (const MountPoint& p : layout) beacons.push_back(world.mounts.beacon(p));
  return soft ? world.score.soft_value(beacons) : LayoutScore::value(world.score.of(beacons));
}

/// Lowest value of all layouts with this number of different poles.
double least_of_all(World& world, std::size_t count) {
  const auto poles = all_poles(world);
  std::vector<int> chosen(poles.size(), 0);
  std::fill(chosen.end() - static_cast<std::ptrdiff_t>(count), chosen.end(), 1);
  double least = INFINITY;
  do {
    std::vector<MountPoint> layout;
    for (std::size_t i = 0; i < poles.size(); ++i)
      if (chosen[i] != 0) layout.push_back(poles[i]);
    least = std::min(least, value_of(world, layout));
  } while (std::next_permutation(chosen.begin(), chosen.end()));
  return least;
}

TEST(PlacementSearch, GreedyTakesThePlaceThatHelpsMostEachTime) {
  World world;
  const auto greedy = greedy_layout({world.mounts, {}}, 5, world.score);
  ASSERT_EQ(greedy.size(), 5U);
  std::vector<MountPoint> layout;
  for (const MountPoint& taken : greedy) {
    double least = INFINITY;
    for (const MountPoint& pole : all_poles(world)) {
      auto tried = layout;
      tried.push_back(pole);
      least = std::min(least, value_of(world, tried, /*soft=*/true));
    }
    layout.push_back(taken);
    // A place takes the lead by a part of 1e-4 only.
    EXPECT_LE(value_of(world, layout, true), least * (1 + 1.01e-4)) << layout.size();
  }
}

TEST(PlacementSearch, FindsTheBestOfAllChoices) {
  World world;
  PlacementOptions options;
  options.global = GlobalAlgorithm::kNone, options.local = LocalAlgorithm::kNone;
  for (const std::size_t count : {3U, 4U, 5U}) {
    const SearchResult found = search_layout({world.mounts, {}}, count, world.score, options, {});
    double best = INFINITY;
    for (const auto& layout : found.layouts) {
      ASSERT_EQ(layout.size(), count);
      best = std::min(best, value_of(world, layout));
    }
    // Exchanges stop when no single one improves: the best of 84 to 126 layouts is within reach, and a beacon
    // less would cost about ten times as much.
    const double least = least_of_all(world, count);
    EXPECT_GE(best, least * (1 - 1e-9));
    EXPECT_LE(best, least * 1.02) << count;
    EXPECT_FALSE(found.interrupted);
    EXPECT_GT(found.evaluations, 0U);
  }
}

TEST(PlacementSearch, AStartIsNeverLost) {
  World world;
  PlacementOptions options;
  options.global = GlobalAlgorithm::kNone, options.local = LocalAlgorithm::kNone;
  const auto poles = all_poles(world);
  const std::vector<MountPoint> start = {poles[0], poles[3], poles[4], poles[7]};
  const SearchResult found = search_layout({world.mounts, {}}, 4, world.score, options, {start});
  double best = INFINITY;
  for (const auto& layout : found.layouts) best = std::min(best, value_of(world, layout));
  EXPECT_LE(best, value_of(world, start));
}

TEST(PlacementSearch, KeptBeaconsAreThereFromTheBeginning) {
  World world;
  // Beacons in one corner need the others elsewhere.
  const std::vector<SurveyBeacon> kept = {{"K0", {1, 1, 3}}, {"K1", {1.5, 1, 3}}};
  const auto greedy = greedy_layout({world.mounts, kept}, 1, world.score);
  double least = INFINITY, taken = 0.0;
  for (const MountPoint& pole : all_poles(world)) {
    auto beacons = kept;
    beacons.push_back(world.mounts.beacon(pole));
    least = std::min(least, world.score.soft_value(beacons));
  }
  auto beacons = kept;
  beacons.push_back(world.mounts.beacon(greedy[0]));
  taken = world.score.soft_value(beacons);
  EXPECT_LE(taken, least * (1 + 1.01e-4));
}

TEST(PlacementSearch, RefiningGoesDownOnly) {
  test::Hall hall = test::rectangle_hall();
  const SurveyModel model = must(make_empty_survey_model(hall.site, hall.scene));
  const MountSpace mounts = must(MountSpace::of(hall.scene));
  LayoutScore score(model, poses_of(must(make_floor_grid(model, hall.scene, 2.0)), 0.0), {});
  const std::vector<MountPoint> start = mounts.regular(4, 0.3);
  const auto value = [&](const std::vector<MountPoint>& layout) {
    std::vector<SurveyBeacon> beacons;
    for (const MountPoint& p : layout) beacons.push_back(mounts.beacon(p));
    return LayoutScore::value(score.of(beacons));
  };
  for (const LocalAlgorithm local :
       {LocalAlgorithm::kSbplx, LocalAlgorithm::kBobyqa, LocalAlgorithm::kCobyla}) {
    PlacementOptions options;
    options.local = local;
    options.evaluations = 200;
    SearchResult result;
    const auto better = refine_layout({mounts, {}}, start, score, options, result);
    EXPECT_LT(value(better), value(start)) << static_cast<int>(local);
    EXPECT_LE(result.evaluations, 202U) << "the budget";
    for (const MountPoint& p : better) {
      EXPECT_TRUE(p.along >= 0 && p.along <= 1 && p.across >= 0 && p.across <= 1);
    }
  }
}

TEST(PlacementSearch, StopsWhereOneHasHadEnough) {
  World world;
  int asked = 0;
  PlacementOptions options;
  options.on_progress = [&](double fraction) {
    EXPECT_GE(fraction, 0.0);
    EXPECT_LE(fraction, 1.0);
    return ++asked < 2;
  };
  const SearchResult found = search_layout({world.mounts, {}}, 4, world.score, options, {});
  EXPECT_TRUE(found.interrupted);
  EXPECT_GE(found.layouts.size(), 1U) << "what there is";
}

}  // namespace placement_search_test
}  // namespace octant::survey
