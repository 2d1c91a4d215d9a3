// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/long_log.h"

#include <gtest/gtest.h>

#include "calib/adjust/adjust.h"
#include "calib/errors/reliability.h"
#include "models/localizers/least_squares/linear_ranges.h"
#include "models/trajectory/linearise.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/internal_covariance.h"
#include "tests/support/statistics.h"

namespace octant::test {
namespace long_log_test {

Scenario long_hall(int epochs) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  s.heldout_path.epochs = 1;
  return s;
}

TEST(LinearRanges, AreNearEnoughToSettleFrom) {
  const World world = must(simulate(without_noise(long_hall(60)), 1));
  calib::Problem problem = problem_of(world);
  Trajectory& t = problem.trajectories[0];
  const SharedState truth = shared_state(world.truth);
  int placed = 0;
  for (const Segment& s : t.segments) {
    if (!place_by_linear_ranges(t, s, truth, std::vector<bool>(8, true))) continue;
    ++placed;
    Pose T;
    ASSERT_TRUE(interpolate_poses(world.run.truth, t.nodes[s.first_node].time_s, 1.0, T));
    const Pose& found = t.nodes[s.first_node].T_map_vehicle;
    EXPECT_LT((found.translation_m - T.translation_m).norm(), 0.1);
    EXPECT_LT(std::abs(wrap_angle(found.heading_rad() - T.heading_rad())), 0.3);
  }
  EXPECT_GT(placed, 50);
}

TEST(LinearRanges, TwoBeaconsAndBeaconsInLineTellNothing) {
  const World world = must(simulate(long_hall(20), 1));
  calib::Problem problem = problem_of(world);
  Trajectory& t = problem.trajectories[0];
  SharedState state = shared_state(world.truth);
  std::vector<bool> two(8, false);
  two[0] = two[1] = true;
  for (const Segment& s : t.segments) EXPECT_FALSE(place_by_linear_ranges(t, s, state, two));
  for (std::size_t b = 0; b < 8; ++b) state.beacon_p_map_m[b] = {static_cast<double>(b), 0.0, 2.5};
  for (const Segment& s : t.segments)
    EXPECT_FALSE(place_by_linear_ranges(t, s, state, std::vector<bool>(8, true)));
}

// The whole log completes the solution of its part: sigmas decrease with the root of the number, and remain
// realistic.
TEST(LongLog, IsCalibratedByWayOfAPart) {
  const World world = must(simulate(long_hall(4500), 1));
  const calib::Problem problem = problem_of(world);
  ASSERT_TRUE(calib::is_long(problem));
  const calib::Solution solution = calib::solve(problem, {});
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 0.002);
  const BeaconErrors errors = beacon_errors(world, solution);
  const auto dof = static_cast<double>(errors.error.size());
  EXPECT_LT(errors.nees(), chi2_quantile(1 - 1e-4, dof));
  EXPECT_GT(errors.nees(), chi2_quantile(1e-4, dof));
  EXPECT_LT(solution.statistics.rejected, world.run.arrivals.size() / 1000);
  EXPECT_GT(solution.statistics.chi2_p, 1e-4);
}

TEST(LongLog, DoesNotDependOnThreads) {
  Scenario s = long_hall(4500);
  s.echo_fraction = 0.05;
  const World world = must(simulate(s, 2));
  const calib::Problem problem = problem_of(world);
  calib::SolveOptions options;
  options.threads = 1;
  const calib::Solution one = calib::solve(problem, options);
  options.threads = 3;
  const calib::Solution three = calib::solve(problem, options);
  ASSERT_EQ(one.status, calib::SolveStatus::kConverged);
  EXPECT_LT(worst_beacon_m(world, one), 0.003);
  for (std::size_t b = 0; b < 8; ++b)
    EXPECT_LT((one.state.beacon_p_map_m[b] - three.state.beacon_p_map_m[b]).norm(), 1e-12);
  EXPECT_EQ(one.statistics.rejected, three.statistics.rejected);
}

// If only some epochs are examined, results for a beacon as a whole are still those of all.
TEST(LongLog, ReliabilityOfSomeEpochsIsThatOfAll) {
  const World world = must(simulate(long_hall(300), 3));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem, {});
  const calib::ParameterLayout layout = calib::make_layout(problem, solution.state);
  const calib::Covariance C = internal_covariance(layout, solution);
  const auto reliability = [&](std::size_t all_epochs) {
    return calib::reliability_of(problem, layout, solution.trajectories, solution.state, C,
                                 solution.beacon_status, 1.0, 2, all_epochs);
  };
  const calib::Reliability all = reliability(1000), some = reliability(60);
  ASSERT_EQ(all.stride, 1U);
  ASSERT_EQ(some.stride, 5U);
  EXPECT_NEAR(some.mean_redundancy, all.mean_redundancy, 0.02);
  EXPECT_NEAR(some.redundancy_sum, all.redundancy_sum, 0.03 * all.redundancy_sum);
  for (std::size_t b = 0; b < 8; ++b) {
    EXPECT_EQ(some.beacons[b].used, all.beacons[b].used);
    ASSERT_TRUE(all.beacons[b].lateness_mdb_s && some.beacons[b].lateness_mdb_s) << b;
    EXPECT_NEAR(*some.beacons[b].lateness_mdb_s, *all.beacons[b].lateness_mdb_s,
                1e-3 * *all.beacons[b].lateness_mdb_s)
        << b;
    EXPECT_NEAR(*some.beacons[b].lateness_influence_m, *all.beacons[b].lateness_influence_m,
                1e-2 * *all.beacons[b].lateness_influence_m)
        << b;
  }
}

// In space each time stands separately at its measured pose. Three receivers of one sound share the error of
// that pose, and the sigmas include this.
TEST(LongLog, OfMeasuredPosesInSpaceIsCalibratedByWayOfAPart) {
  Scenario s = drive_scenario(1500.0);
  s.site.motion = Motion::kSpatial;
  s.log_poses = true;
  s.pose_accuracy = {.position_sigma_m = 0.05, .heading_sigma_rad = 0.02, .attitude_sigma_rad = 0.02};
  const World world = must(simulate(s, 1));
  const calib::Problem problem = problem_of(world);
  ASSERT_TRUE(calib::is_long(problem));
  EXPECT_LT(problem.trajectories[0].nodes.size(), world.run.arrivals.size() / 2);
  calib::SolveOptions options;
  options.threads = 2;
  const calib::Solution solution = calib::solve(problem, options);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 0.05);
  const BeaconErrors errors = beacon_errors(world, solution);
  const auto dof = static_cast<double>(errors.error.size());
  EXPECT_LT(errors.nees(), chi2_quantile(1 - 1e-4, dof));
  EXPECT_LT(solution.statistics.rejected, world.run.arrivals.size() / 1000);
  EXPECT_NEAR(solution.tof_sigma_s, s.site.noise.tof_sigma_s, 0.2 * s.site.noise.tof_sigma_s);
  EXPECT_GT(solution.reliability.stride, 1u);  // thousands of states tell the redundancy as well as all do
}

// A part of a long drive finds the shared parameters, the whole of it ends at its own optimum.
TEST(LongDrive, IsCalibratedByWayOfAPart) {
  Scenario s = drive_scenario(500.0);
  s.echo_fraction = 0.02;
  const World world = must(simulate(s, 1));
  const calib::Problem problem = problem_of(world);
  ASSERT_TRUE(calib::is_long(problem));
  const calib::Solution solution = calib::solve(problem, {});
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  const BeaconErrors errors = beacon_errors(world, solution);
  const auto dof = static_cast<double>(errors.error.size());
  EXPECT_LT(errors.nees(), chi2_quantile(1 - 1e-4, dof));
  EXPECT_GT(errors.nees(), chi2_quantile(1e-4, dof));
  // No further decrease is possible from there.
  calib::ParameterLayout layout = calib::make_layout(problem, solution.state);
  std::vector<Trajectory> trajectories = solution.trajectories;
  Eigen::VectorXd x = layout.vector_of(solution.state);
  calib::AdjustOptions options;
  options.function_tolerance = 1e-14;
  const calib::AdjustResult again = calib::adjust(problem, layout, trajectories, x, options);
  EXPECT_NEAR(again.cost, solution.final_cost, 1e-4);
  Eigen::VectorXd per_si(layout.size());
  for (int i = 0; i < layout.size(); ++i)
    per_si[i] = 1.0 / layout.parameters[static_cast<std::size_t>(i)].si_per_unit;
  const Eigen::VectorXd sigma = per_si.cwiseProduct(solution.covariance.matrix.diagonal().cwiseSqrt());
  const Eigen::VectorXd moved = (x - layout.vector_of(solution.state)).cwiseQuotient(sigma);
  EXPECT_LT(moved.cwiseAbs().maxCoeff(), 0.01);
}

TEST(LongDrive, DoesNotDependOnThreads) {
  const World world = must(simulate(drive_scenario(500.0), 2));
  const calib::Problem problem = problem_of(world);
  calib::SolveOptions options;
  const calib::Solution one = calib::solve(problem, options);
  options.threads = 3;
  const calib::Solution three = calib::solve(problem, options);
  ASSERT_EQ(one.status, calib::SolveStatus::kConverged);
  for (std::size_t b = 0; b < 8; ++b) EXPECT_EQ(one.state.beacon_p_map_m[b], three.state.beacon_p_map_m[b]);
  EXPECT_EQ(one.statistics.rejected, three.statistics.rejected);
  EXPECT_EQ(one.reliability.redundancy_sum, three.reliability.redundancy_sum);
}

// Segments of a long drive with margins have the redundancies that they have within it.
TEST(LongDrive, ReliabilityOfSomeStretchesIsThatOfAll) {
  const World world = must(simulate(drive_scenario(260.0), 3));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem, {});
  const calib::ParameterLayout layout = calib::make_layout(problem, solution.state);
  const calib::Covariance C = internal_covariance(layout, solution);
  const auto reliability = [&](std::size_t all_epochs) {
    return calib::reliability_of(problem, layout, solution.trajectories, solution.state, C,
                                 solution.beacon_status, 1.0, 2, all_epochs);
  };
  const calib::Reliability all = reliability(10'000), some = reliability(2'000);
  ASSERT_EQ(all.stride, 1U);
  ASSERT_GT(some.stride, 1U);
  EXPECT_NEAR(some.redundancy_sum, all.redundancy_sum, 0.03 * all.redundancy_sum);
  std::vector<double> redundancy(world.run.arrivals.size(), NAN);
  for (const calib::ArrivalReliability& a : all.arrivals) redundancy[a.arrival] = a.redundancy;
  EXPECT_GT(some.arrivals.size(), all.arrivals.size() / 5);
  for (const calib::ArrivalReliability& a : some.arrivals)
    ASSERT_NEAR(a.redundancy, redundancy[a.arrival], 1e-3) << a.arrival;
}

}  // namespace long_log_test
}  // namespace octant::test
