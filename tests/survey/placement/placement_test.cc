// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Placement: compared with regular, random and greedy layouts in three halls; mounts; kept beacons and
// refusals.
#include "survey/placement/placement.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "models/physics/polygon.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/page/proof_sheet.h"
#include "survey/placement/mounts.h"
#include "tests/survey/halls.h"

namespace octant::survey {
namespace placement_test {

using test::Hall;
using test::must;

constexpr double kAsRegularOrBetter =
    0.85;  ///< requirement on a plan: 15 % below a regular layout's worst error

/// The scene without the site's one beacon.
SurveyModel model_of(const Hall& hall) { return must(make_empty_survey_model(hall.site, hall.scene)); }

/// A small budget: these tests are about what always holds.
PlacementOptions quick() {
  PlacementOptions o;
  o.evaluations = 150;
  o.restarts = 0;
  o.cells = 80;
  o.final_cells = 400;
  return o;
}

void expect_better_than_regular(const Hall& hall, std::size_t beacons, const PlacementOptions& options) {
  const Placement p = must(place_beacons(model_of(hall), hall.scene, beacons, options));
  EXPECT_EQ(p.beacons.size(), beacons);
  EXPECT_TRUE(p.figures.covers_all()) << hall.name << " " << beacons;
  EXPECT_LE(p.figures.objective_m, p.greedy.objective_m) << hall.name << " " << beacons;
  EXPECT_LE(p.figures.objective_m, kAsRegularOrBetter * p.regular.objective_m) << hall.name << " " << beacons;
  std::printf("%s, %zu beacons: worst %.1f mm, greedy %.1f, regular %.1f%s, random %.1f; %.2f of regular\n",
              hall.name.c_str(), beacons, 1e3 * p.figures.objective_m, 1e3 * p.greedy.objective_m,
              1e3 * p.regular.objective_m, p.regular.covers_all() ? "" : " (not covered)",
              1e3 * p.random.objective_m, p.figures.objective_m / p.regular.objective_m);
}

TEST(Placement, FourBeaconsInARectangle) {
  expect_better_than_regular(test::rectangle_hall(), 4,
                             {.restarts = 2, .evaluations = 600, .cells = 150, .final_cells = 3000});
}
TEST(Placement, FourBeaconsInAnL) {
  expect_better_than_regular(test::l_hall(), 4,
                             {.restarts = 2, .evaluations = 600, .cells = 150, .final_cells = 3000});
}
TEST(Placement, FourBeaconsInAWarehouse) {
  expect_better_than_regular(test::warehouse_hall(), 4,
                             {.restarts = 2, .evaluations = 600, .cells = 150, .final_cells = 3000});
}

/// The whole must: minutes, so in the slow set only (tests/CMakeLists.txt).
TEST(Placement, DISABLED_FourToTwelveBeaconsInThreeHalls) {
  for (const Hall& hall : test::three_halls())
    for (std::size_t n = 4; n <= 12; ++n) expect_better_than_regular(hall, n, {.threads = 2});
}

TEST(Placement, TheSameAgainWithItsSeed) {
  const Hall hall = test::rectangle_hall();
  const SurveyModel model = model_of(hall);
  PlacementOptions o = quick();
  const Placement a = must(place_beacons(model, hall.scene, 4, o));
  o.threads = 2;
  const Placement b = must(place_beacons(model, hall.scene, 4, o));
  ASSERT_EQ(a.beacons.size(), b.beacons.size());
  for (std::size_t i = 0; i < a.beacons.size(); ++i)
    EXPECT_EQ(a.beacons[i].beacon.p_map_m, b.beacons[i].beacon.p_map_m) << "threads change nothing";
  EXPECT_EQ(a.evaluations, b.evaluations);
}

TEST(Placement, NeverWorseThanGreedyByAnyAlgorithm) {
  // Ten beacons: greedy choices cover this hall and are better than some that a search sets out from.
  const Hall hall = test::rectangle_hall();
  const SurveyModel model = model_of(hall);
  for (const char* global : {"none", "crs2", "direct", "isres", "esch"})
    for (const char* local : {"none", "bobyqa", "cobyla", "sbplx"}) {
      if (global != std::string("none") && local != std::string("none")) continue;  // each algorithm once
      PlacementOptions o = quick();
      o.global = global_algorithm(global).value();
      o.local = local_algorithm(local).value();
      o.evaluations = 30;
      const Placement p = must(place_beacons(model, hall.scene, 10, o));
      EXPECT_LT(p.greedy.objective_m, p.regular.objective_m);
      EXPECT_LE(p.figures.objective_m, p.greedy.objective_m) << global << " " << local;
    }
  EXPECT_FALSE(global_algorithm("newton"));
}

// Between the grid's places: what NLopt's algorithms add to greedy choices and exchanges, and that both kinds
// are asked.
TEST(Placement, NloptGainsOnTheGrid) {
  const Hall hall = test::warehouse_hall();
  const SurveyModel model = model_of(hall);
  PlacementOptions o = quick();
  o.evaluations = 400;
  bool local = false, global = false;  // by the shares of the work that they report
  o.on_progress = [&](double share) {
    local = local || (share > 0.31 && share < 0.59);
    global = global || (share > 0.61 && share < 0.84);
    return true;
  };
  const double both_m = must(place_beacons(model, hall.scene, 5, o)).figures.objective_m;
  EXPECT_TRUE(local);
  EXPECT_TRUE(global);
  o.local = LocalAlgorithm::kNone;
  o.global = GlobalAlgorithm::kNone;
  local = global = false;
  const double grid_m = must(place_beacons(model, hall.scene, 5, o)).figures.objective_m;
  EXPECT_FALSE(local || global);
  EXPECT_LT(both_m, 0.95 * grid_m);
}

TEST(Placement, EachGoalIsBestByItsOwnMeasure) {
  const Hall hall = test::rectangle_hall();
  const SurveyModel model = model_of(hall);
  std::vector<LayoutFigures> of;
  for (const auto goal : {PlacementGoal::kWorst, PlacementGoal::kP95, PlacementGoal::kMean}) {
    PlacementOptions o = quick();
    o.evaluations = 600;
    o.goal = goal;
    of.push_back(must(place_beacons(model, hall.scene, 5, o)).figures);
  }
  // Searches end near the optimum; a plan for another goal must not be better by more than this.
  constexpr double kShortOfTheBest = 1.05;
  EXPECT_LE(of[0].worst_m, kShortOfTheBest * std::min(of[1].worst_m, of[2].worst_m));
  EXPECT_LE(of[1].p95_m, kShortOfTheBest * std::min(of[0].p95_m, of[2].p95_m));
  EXPECT_LE(of[2].mean_m, kShortOfTheBest * std::min(of[0].mean_m, of[1].mean_m));
  // And the goal makes a difference: a good worst cell costs a little everywhere.
  EXPECT_LT(of[0].worst_m, 0.8 * std::min(of[1].worst_m, of[2].worst_m));
  EXPECT_LT(of[1].p95_m, 0.99 * of[0].p95_m);
  EXPECT_LT(of[2].mean_m, 0.99 * of[0].mean_m);
}

// References of a plan: evenly spaced beacons at the best of several phases, and the median of random
// layouts.
TEST(Placement, RegularAndRandomAreWhatTheySay) {
  const Hall hall = test::rectangle_hall();
  const SurveyModel model = model_of(hall);
  const PlacementOptions o = quick();
  const Placement p = must(place_beacons(model, hall.scene, 6, o));
  const MountSpace space = must(MountSpace::of(hall.scene));
  const auto objective_m = [&](const std::vector<MountPoint>& points) {
    SurveyModel with = model;
    for (const MountPoint& point : points) with.beacons.push_back(space.beacon(point));
    return must(layout_figures(with, hall.scene, o)).objective_m;
  };
  double best_m = INFINITY;
  for (int phase = 0; phase < 8; ++phase)
    best_m = std::min(best_m, objective_m(space.regular(6, phase / 8.0)));
  EXPECT_NEAR(p.regular.objective_m, best_m, 1e-9 * best_m);
  // Six along a round of 76 m: equal steps.
  for (const auto& points = space.regular(6, 0.25); const std::size_t k : {0U, 2U, 4U})
    EXPECT_NEAR(points[k + 1].along - points[k].along, 1.0 / 6, 1e-12);
  Random draws(77);
  std::vector<double> random_m;
  for (int i = 0; i < 200; ++i) random_m.push_back(objective_m(space.random(6, draws)));
  std::sort(random_m.begin(), random_m.end());
  // The median of 25 is between these quantiles of all layouts but for a chance of 1e-4 or so.
  EXPECT_GT(p.random.objective_m, random_m[30]);
  EXPECT_LT(p.random.objective_m, random_m[170]);
}

TEST(Placement, KeptBeaconsStayAndHelp) {
  Hall hall = test::rectangle_hall();
  hall.site.beacons = {test::beacon("old", {0.1, 0.1, 3.0}, 0.1), test::beacon("B0", {23.9, 13.9, 3.0}, 0.1)};
  const SurveyModel model = must(make_survey_model(hall.site, hall.scene));
  PlacementOptions o = quick();
  o.keep = true;
  const Placement p = must(place_beacons(model, hall.scene, 5, o));
  ASSERT_EQ(p.beacons.size(), 5U);
  EXPECT_EQ(p.beacons[0].beacon.p_map_m, model.beacons[0].p_map_m);
  EXPECT_TRUE(p.beacons[1].mount.empty());
  EXPECT_FALSE(p.beacons[2].mount.empty());
  std::vector<std::string> names;
  for (const auto& b : p.beacons) names.push_back(b.beacon.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end()) << "new names are new";
  EXPECT_FALSE(place_beacons(model, hall.scene, 2, o));
}

TEST(Placement, AsFewAsReachATolerance) {
  const Hall hall = test::rectangle_hall();
  const SurveyModel model = model_of(hall);
  const PlacementOptions o = quick();
  const double five_m = must(place_beacons(model, hall.scene, 5, o)).figures.objective_m;
  const SmallestPlacement s = must(smallest_placement(model, hall.scene, five_m, 12, o));
  EXPECT_TRUE(s.reached);
  EXPECT_LE(s.placement.figures.objective_m, five_m);
  EXPECT_LE(s.placement.beacons.size(), 5U) << "five are known to reach it";
  const SmallestPlacement never = must(smallest_placement(model, hall.scene, 1e-6, 6, o));
  EXPECT_FALSE(never.reached);
  EXPECT_EQ(never.placement.beacons.size(), 6U);
}

TEST(Placement, CoverageIsAskedOfEveryCell) {
  const Hall hall = test::l_hall();
  PlacementOptions o = quick();
  o.coverage = 4;
  o.evaluations = 300;
  const Placement p = must(place_beacons(model_of(hall), hall.scene, 6, o));
  ASSERT_TRUE(p.figures.covers_all());
  SurveyModel model = model_of(hall);
  for (const auto& b : p.beacons) model.beacons.push_back(b.beacon);
  PlacementOptions five = o;
  five.coverage = 7;
  EXPECT_DOUBLE_EQ(must(layout_figures(model, hall.scene, five)).covered_fraction, 0.0)
      << "six beacons are never seven";
  EXPECT_DOUBLE_EQ(must(layout_figures(model, hall.scene, o)).objective_m, p.figures.objective_m);
}

TEST(Placement, StopsWhenAsked) {
  const Hall hall = test::rectangle_hall();
  PlacementOptions o = quick();
  o.on_progress = [](double fraction) { return fraction < 0.2; };
  EXPECT_TRUE(must(place_beacons(model_of(hall), hall.scene, 4, o)).interrupted);
}

TEST(Placement, RefusesASceneWithoutMountsOrFloor) {
  Hall hall = test::rectangle_hall();
  const SurveyModel model = model_of(hall);
  EXPECT_FALSE(place_beacons(model, hall.scene, 0, quick()));
  hall.scene.mounts.clear();
  const auto none = place_beacons(model, hall.scene, 4, quick());
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("scene.mounts"), std::string::npos);
  hall.scene.floor_m.clear();
  EXPECT_FALSE(make_empty_survey_model(hall.site, hall.scene));
}

TEST(Mounts, EveryPlaceIsOnAMount) {
  Hall hall = test::l_hall();
  SceneMount ceiling;
  ceiling.name = "ceiling";
  ceiling.kind = SceneMount::Kind::kCeiling;
  ceiling.points_m = {{1, 1}, {9, 1}, {9, 8}, {5, 8}, {5, 4}, {1, 4}};
  ceiling.low_m = ceiling.high_m = 5.0;
  SceneMount pole;
  pole.name = "pole";
  pole.kind = SceneMount::Kind::kPole;
  pole.points_m = {{12, 4}};
  pole.low_m = 1.0, pole.high_m = 2.0;
  hall.scene.mounts.push_back(ceiling);
  hall.scene.mounts.push_back(pole);
  const MountSpace space = must(MountSpace::of(hall.scene));
  Random draws(3);
  std::vector<MountPoint> points = space.random(500, draws);
  for (const auto& p : space.grid(60)) points.push_back(p);
  std::size_t on_pole = 0, under_ceiling = 0;
  for (const MountPoint& p : points) {
    const SurveyBeacon b = space.beacon(p);
    const Eigen::Vector2d at = b.p_map_m.head<2>();
    if (space.mount_name(p) == "pole") {
      ++on_pole;
      EXPECT_EQ(at, Eigen::Vector2d(12, 4));
      EXPECT_TRUE(b.axis.isZero());
    } else if (space.mount_name(p) == "ceiling") {
      ++under_ceiling;
      EXPECT_LT(is_inside(ceiling.points_m, at) ? 0.0 : distance_to_outline_m(ceiling.points_m, at), 1e-9);
      EXPECT_EQ(b.p_map_m.z(), 5.0);
      EXPECT_EQ(b.axis, Eigen::Vector3d(0, 0, -1));
    } else {
      EXPECT_LT(distance_to_outline_m(hall.scene.floor_m, at), 0.03) << "two centimetres before the wall";
      EXPECT_TRUE(is_inside(hall.scene.floor_m, at))
          << "corners go counter-clockwise: the left of a wall is inside";
      EXPECT_GE(b.p_map_m.z(), 2.0);
      EXPECT_LE(b.p_map_m.z(), 4.0);
      EXPECT_NEAR(b.axis.norm(), 1.0, 1e-12);
    }
  }
  EXPECT_GT(on_pole, 0U);
  EXPECT_GT(under_ceiling, 20U);
  for (const std::size_t n : {1U, 4U, 7U}) EXPECT_EQ(space.regular(n, 0.25).size(), n);
  Scene warehouse = test::warehouse_hall().scene;
  for (const std::size_t n : {1U, 4U, 7U, 12U})
    EXPECT_EQ(must(MountSpace::of(warehouse)).regular(n, 0.5).size(), n);
}

TEST(ProofSheet, EscapesNamesAndDrawsAPointForEachCoveredLayout) {
  const Hall hall = test::rectangle_hall();
  const SurveyModel model = model_of(hall);
  Placement p = must(place_beacons(model, hall.scene, 4, quick()));
  p.beacons[0].beacon.name = "<B&0>";
  ProofSheetInput sheet{.name = "a <hall>",
                        .settings = "goal worst",
                        .created = "now",
                        .program = "octant",
                        .rows = {proof_row(p)},
                        .placement = p,
                        .floor_m = model.floor_m,
                        .walls = model.walls,
                        .tolerance_m = 0.05};
  const std::string html = proof_sheet_html(sheet);
  EXPECT_EQ(html.find("<B&0>"), std::string::npos);
  EXPECT_NE(html.find("&lt;B&amp;0&gt;"), std::string::npos);
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  EXPECT_NE(html.find("tolerance"), std::string::npos);
  const auto count = [](const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
  };
  std::size_t covered = 0;
  for (const LayoutFigures& f : {p.figures, p.greedy, p.regular, p.random}) covered += f.covers_all();
  EXPECT_EQ(count(proof_svg(sheet), "<circle"), covered);
  EXPECT_EQ(count(placement_svg(sheet), "<circle"), 4U);
}

}  // namespace placement_test
}  // namespace octant::survey
