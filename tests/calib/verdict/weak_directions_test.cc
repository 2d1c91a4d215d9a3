// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/weak_directions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace weak_directions_test {

using testing::Contains;
using testing::HasSubstr;

TEST(WeakDirections, AGoodSiteHasNone) {
  const World world = must(simulate(hall_scenario(), 1));
  EXPECT_TRUE(solution_of(world).weak.empty());
}

TEST(WeakDirections, AreToldInWordsWithAConsequenceAndARemedy) {
  Scenario s = hall_scenario();
  s.path.epochs = 30;
  World world = must(simulate(s, 2));
  world.site.tolerance.beacon_m = 0.012;  // the same sigmas are weak for a stricter site
  const calib::Solution solution = solution_of(world);
  ASSERT_FALSE(solution.weak.empty());
  for (const calib::WeakDirection& w : solution.weak) {
    EXPECT_FALSE(w.description.empty());
    EXPECT_FALSE(w.remedy.empty()) << w.description;
    EXPECT_FALSE(w.parameters.empty()) << w.description;
    EXPECT_TRUE(std::isfinite(w.consequence_m));
    EXPECT_GT(w.sigma_m, 0.0) << w.description;
    if (!w.lone_beacon) {
      EXPECT_GT(w.consequence_m, 0.0);
    }
  }
}

TEST(WeakDirections, NameTheSpeedWhereAFreeScaleIsBarelyHeld) {
  Scenario s = hall_scenario();
  World world = must(simulate(s, 3));
  world.site.speed_sigma_mps = 20.0;
  for (SiteBeacon& b : world.site.beacons) b.sigma_m.fill(0.5);  // no control point holds the scale
  const calib::Solution solution = solution_of(world);
  std::vector<std::string> descriptions;
  for (const calib::WeakDirection& w : solution.weak) descriptions.push_back(w.description);
  EXPECT_THAT(descriptions, Contains(HasSubstr("speed")));
}

TEST(WeakDirections, ShiftAtTheRobotIsThatOfAMovedMap) {
  const World world = must(simulate(hall_scenario(), 4));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  calib::Problem all_free = problem;
  for (SiteBeacon& b : all_free.site.beacons) b.sigma_m.fill(1.0);
  const calib::ParameterLayout layout = calib::make_layout(all_free, solution.state);
  const Eigen::VectorXd x = layout.vector_of(solution.state);
  Eigen::VectorXd y = x;
  for (const auto& columns : layout.beacon)
    y[columns[0]] += 0.01;  // the whole map goes 10 mm east, and the robot with it
  EXPECT_NEAR(calib::shift_at_robot_m(layout, x, y, solution.trajectories), 0.01, 1e-6);
}

}  // namespace weak_directions_test
}  // namespace octant::test
