// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Criteria of layouts, compared with single sigmas and sorted lists.
#include "survey/placement/layout_score.h"
#include "survey/geometry/make_survey_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/survey/brute_force.h"
#include "tests/survey/halls.h"

namespace octant::survey {
namespace layout_score_test {

using test::must;

SurveyModel hall_model(double range_m = 30.0) {
  test::Hall hall = test::rectangle_hall();
  hall.scene.acoustics.range_m = range_m;
  SurveyModel model = must(make_empty_survey_model(hall.site, hall.scene));
  model.walls.clear();  // the outline, which no path crosses
  return model;
}

std::vector<SurveyBeacon> some_beacons(Random& draws, int count) {
  std::vector<SurveyBeacon> beacons;
  for (int i = 0; i < count; ++i)
    beacons.push_back({"B", {draws.uniform(0, 24), draws.uniform(0, 14), draws.uniform(2, 4)}});
  return beacons;
}

PoseList some_poses(Random& draws, std::size_t count) {
  PoseList poses;
  for (std::size_t i = 0; i < count; ++i) poses.add(draws.uniform(0, 24), draws.uniform(0, 14), 0, 0);
  return poses;
}

/// Errors by definition: the fix's sigma, or the hall's size times one plus the number of missing beacons.
std::vector<double> errors_of(SurveyModel model, const std::vector<SurveyBeacon>& beacons,
                              const PoseList& poses, int required) {
  model.beacons = beacons;
  const double size_m = std::sqrt(24.0 * 14.0);
  std::vector<double> errors;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto arrivals = test::brute_arrivals(model, poses.x_m[i], poses.y_m[i], poses.z_m[i], 0);
    const int missing = std::max(0, required - static_cast<int>(arrivals.size()));
    double sigma_m = INFINITY;
    if (static_cast<int>(arrivals.size()) >= model.unknowns.count()) {
      const Eigen::MatrixXd C = test::information_of(model, arrivals, true).inverse();
      sigma_m = std::sqrt(C(0, 0) + C(1, 1));
    }
    errors.push_back(missing == 0 && sigma_m < size_m ? sigma_m : size_m * (1 + missing));
  }
  return errors;
}

double mean(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

/// Element of a sorted list at a share, rounded down.
double quantile(std::vector<double> v, double share) {
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(share * static_cast<double>(v.size() - 1))];
}

// A range's noise of some centimetres through 1e-10 of rounding in the lanes.
constexpr double kRounding = 1e-8;

TEST(LayoutScore, FiguresAreThoseOfTheSigmasOneByOne) {
  Random draws(20261125);
  for (const double range_m : {9.0, 14.0, 30.0})
    for (const int coverage : {0, 5})
      for (const PlacementGoal goal : {PlacementGoal::kWorst, PlacementGoal::kP95, PlacementGoal::kMean}) {
        const SurveyModel model = hall_model(range_m);
        const PoseList poses = some_poses(draws, 97);
        const auto beacons = some_beacons(draws, 7);
        LayoutScore score(model, poses, {.goal = goal, .coverage = coverage});
        const LayoutFigures f = score.of(beacons);
        // x, y and the cycle's offset: three ranges at least.
        const auto errors = errors_of(model, beacons, poses, std::max(3, coverage));
        std::vector<double> covered;
        for (const double e : errors)
          if (e < std::sqrt(24.0 * 14.0)) covered.push_back(e);
        EXPECT_DOUBLE_EQ(f.covered_fraction, static_cast<double>(covered.size()) / 97);
        EXPECT_EQ(f.covers_all(), covered.size() == 97U);
        EXPECT_NEAR(f.mean_with_uncovered_m, mean(errors), kRounding * mean(errors));
        if (!covered.empty()) {
          EXPECT_NEAR(f.worst_m, *std::max_element(covered.begin(), covered.end()), kRounding * f.worst_m);
          EXPECT_NEAR(f.mean_m, mean(covered), kRounding * f.mean_m);
          EXPECT_NEAR(f.p95_m, quantile(covered, 0.95), kRounding * f.p95_m);
        }
        const double expected = goal == PlacementGoal::kWorst
                                    ? *std::max_element(errors.begin(), errors.end())
                                : goal == PlacementGoal::kP95 ? quantile(errors, 0.95)
                                                              : mean(errors);
        EXPECT_NEAR(f.objective_m, expected, kRounding * expected);
        ASSERT_EQ(score.errors_m().size(), 97U);
        for (std::size_t i = 0; i < 97; ++i)
          EXPECT_NEAR(score.errors_m()[i], errors[i], kRounding * errors[i]);
      }
}

TEST(LayoutScore, WithoutBeaconsNothingIsCovered) {
  Random draws(2);
  LayoutScore score(hall_model(), some_poses(draws, 20), {});
  const LayoutFigures f = score.of({});
  EXPECT_EQ(f.covered_fraction, 0.0);
  EXPECT_EQ(f.worst_m, 0.0);
  EXPECT_DOUBLE_EQ(f.objective_m, 4 * std::sqrt(24.0 * 14.0)) << "three ranges are missing";
}

/// The sum of a search over beacons equals the value of the whole layout.
TEST(LayoutScore, SumsOfLayersAreTheLayout) {
  Random draws(3);
  for (const PlacementGoal goal : {PlacementGoal::kWorst, PlacementGoal::kP95, PlacementGoal::kMean})
    for (const double range_m : {12.0, 30.0}) {
      const auto beacons = some_beacons(draws, 6);
      LayoutScore score(hall_model(range_m), some_poses(draws, 53), {.goal = goal});
      LayoutScore::Sum sum = score.no_beacons();
      for (std::size_t k = 0; k + 1 < beacons.size(); ++k) sum.add(score.layer(beacons[k]));
      const BeaconLayer last = score.layer(beacons.back());
      const double added = score.value_with(sum, &last, /*soft=*/false);
      const double soft = score.value_with(sum, &last, /*soft=*/true);
      EXPECT_NEAR(soft / score.soft_value(beacons), 1.0, 1e-12);
      const double whole = LayoutScore::value(score.of(beacons));
      EXPECT_NEAR(added / whole, 1.0, kRounding);
      sum.add(last);
      EXPECT_NEAR(score.value_with(sum, nullptr, false) / added, 1.0, 1e-12);
      sum.add(last, -1);  // and taken away again
      EXPECT_NEAR(score.value_with(sum, &last, false) / added, 1.0, 1e-9);
      EXPECT_EQ(sum.heard.size(), 53U);
    }
}

TEST(LayoutScore, TheMeanBreaksTies) {
  LayoutFigures a, b;
  a.objective_m = b.objective_m = 2.0;
  a.mean_with_uncovered_m = 1.0, b.mean_with_uncovered_m = 1.5;
  EXPECT_LT(LayoutScore::value(a), LayoutScore::value(b));
  b.objective_m = 1.99;  // and no more than ties: a hundredth of the goal outweighs half of the mean
  EXPECT_GT(LayoutScore::value(a), LayoutScore::value(b));
}

/// Far from any fix, one more beacon improves the value a little everywhere; otherwise a search would have no
/// gradient.
TEST(LayoutScore, TheSoftValueFallsWithEachBeaconEvenWhereThereIsNoFix) {
  Random draws(4);
  SurveyModel model = hall_model();
  // The approximate position is uncertain by 20 m in each direction, and a value counts with at most the
  // floor's size: that is larger.
  model.floor_m = {{0, 0}, {40, 0}, {40, 30}, {0, 30}};
  for (const PlacementGoal goal : {PlacementGoal::kWorst, PlacementGoal::kMean}) {
    LayoutScore score(model, some_poses(draws, 40), {.goal = goal});
    auto beacons = some_beacons(draws, 6);
    double before = score.soft_value({});
    EXPECT_TRUE(std::isfinite(before));
    for (std::size_t count = 1; count <= beacons.size(); ++count) {
      const double now =
          score.soft_value({beacons.begin(), beacons.begin() + static_cast<std::ptrdiff_t>(count)});
      EXPECT_LT(now, before) << count;
      before = now;
    }
  }
}

TEST(LayoutScore, FurtherPosesCount) {
  Random draws(5);
  const PoseList poses = some_poses(draws, 30);
  PoseList first, rest;
  for (std::size_t i = 0; i < 30; ++i) (i < 11 ? first : rest).add(poses.x_m[i], poses.y_m[i], 0, 0);
  const auto beacons = some_beacons(draws, 5);
  LayoutScore part(hall_model(), first, {}), whole(hall_model(), poses, {});
  part.add_poses(rest);
  EXPECT_EQ(part.poses().size(), 30U);
  EXPECT_EQ(LayoutScore::value(part.of(beacons)), LayoutScore::value(whole.of(beacons)));
  EXPECT_EQ(part.no_beacons().heard.size(), 30U);
}

}  // namespace layout_score_test
}  // namespace octant::survey
