// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/flips.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace flips_test {

using ::testing::HasSubstr;

TEST(Flips, EpochsThatWereTurnedAreNamed) {
  Scenario s = hall_scenario();
  s.path.epochs = 25;
  const World world = must(simulate(s, 1));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem, {});
  auto before = calib::epoch_headings_rad(solution.trajectories);
  EXPECT_TRUE(calib::report_flips(problem.site, problem.runs, solution.trajectories, before).empty());
  for (const std::size_t k : {3U, 17U}) before[0][k] += std::numbers::pi;
  before[0][5] += 1.0;  // a rough start, no flip
  const auto told = calib::report_flips(problem.site, problem.runs, solution.trajectories, before);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told[0], HasSubstr("2 epochs faced the wrong way"));
  EXPECT_THAT(told[0], HasSubstr(": 3, 17"));
}

}  // namespace flips_test
}  // namespace octant::test
