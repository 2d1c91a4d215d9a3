// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/gates.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace gates_test {

std::size_t count(const std::vector<Trajectory>& trajectories, Rejection reason) {
  std::size_t n = 0;
  for (const Trajectory& t : trajectories)
    n += static_cast<std::size_t>(std::count_if(t.arrivals.begin(), t.arrivals.end(),
                                                [&](const auto& a) { return a.rejection == reason; }));
  return n;
}

Scenario known_hall() {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {0.0, 0.0, 0.0};
  return s;
}

TEST(Gates, TheTriangleLeavesOutEchoesAndNothingElse) {
  const World clean = must(simulate(known_hall(), 1));
  EXPECT_EQ(count(problem_of(clean).trajectories, Rejection::kTriangle), 0U);
  Scenario s = known_hall();
  s.echo_fraction = 0.3;
  s.echo_delay_s = {5e-3, 30e-3};  // 2 to 10 m longer
  const World world = must(simulate(s, 1));
  const calib::Problem problem = problem_of(world);
  std::size_t gated = 0;
  for (const ArrivalObservation& a : problem.trajectories[0].arrivals) {
    if (a.rejection != Rejection::kTriangle) continue;
    ++gated;
    EXPECT_GT(world.run_lateness_s[a.arrival], 0.0);
  }
  EXPECT_GT(gated, 50U);
  // They keep that reason in the list of rejected arrivals.
  const calib::Solution solution = calib::solve(problem, {});
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  std::size_t listed = 0;
  for (const calib::LeftOut& left : solution.left_out) listed += left.reason == Rejection::kTriangle;
  EXPECT_GT(listed, gated / 2);  // the others are of epochs that have no pose
  EXPECT_EQ(listed, count(solution.trajectories, Rejection::kTriangle));
  EXPECT_GT(count(solution.trajectories, Rejection::kLate), 0U);
}

TEST(Gates, ACycleOffsetDropsOutOfTheDifferences) {
  Scenario s = known_hall();
  s.site.timing.clock = Clock::kCycleOffset;
  s.site.timing.delay_per = {};
  s.true_delay_s.reset();
  s.echo_fraction = 0.2;
  s.echo_delay_s = {5e-3, 30e-3};
  const World world = must(simulate(s, 2));
  const calib::Problem problem = problem_of(world);
  EXPECT_GT(count(problem.trajectories, Rejection::kTriangle), 20U);
  for (const ArrivalObservation& a : problem.trajectories[0].arrivals) {
    if (a.rejection == Rejection::kTriangle) {
      EXPECT_GT(world.run_lateness_s[a.arrival], 0.0);
    }
  }
}

TEST(Gates, ChangsRulesAreListedWithTheirReasons) {
  World world = must(simulate(known_hall(), 1));
  world.site.gates.max_range_m = 13.0;  // nothing is heard beyond 12 m in this hall
  world.site.gates.min_range_m = 0.5;
  // A reflection a millisecond behind its arrival, and a range of 20 m.
  Arrival reflection = world.run.arrivals[10], far = world.run.arrivals[20];
  reflection.time_s += 1e-3;
  reflection.tof_s += 1e-3;
  far.tof_s = 0.06;
  world.run.arrivals.insert(world.run.arrivals.begin() + 11, reflection);
  world.run.arrivals[21] = far;
  const calib::Problem problem = problem_of(world);
  EXPECT_EQ(problem.trajectories[0].arrivals[11].rejection, Rejection::kReflection);
  EXPECT_EQ(problem.trajectories[0].arrivals[21].rejection, Rejection::kOutOfRange);
  const calib::Solution solution = calib::solve(problem, {});
  EXPECT_EQ(solution.trajectories[0].arrivals[11].rejection, Rejection::kReflection);
  EXPECT_EQ(solution.trajectories[0].arrivals[21].rejection, Rejection::kOutOfRange);
  EXPECT_EQ(solution.statistics.rejected, 2U);
}

}  // namespace gates_test
}  // namespace octant::test
