// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/calib/calib_support.h"
#include "tests/support/statistics.h"

namespace octant::test {
namespace solve_test {

using calib::SolveStatus;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

TEST(Solve, NoiseFreeWorldGivesTheTruth) {
  World world = must(simulate(without_noise(hall_scenario()), 1));
  world.site.noise.tof_sigma_s = 1e-5;  // a weight is needed; the data carry no noise
  // The priors must have no effect either: wide, or at the truth.
  for (SiteBeacon& b : world.site.beacons)
    for (auto& sigma : b.sigma_m)
      if (*sigma > 0) sigma = 1e4;
  world.site.speed_sigma_mps = 1e4;
  world.site.timing.delay_sigma_s = 1e2;
  for (std::size_t r = 0; r < world.site.receivers.size(); ++r) {
    world.site.receivers[r].position_m = world.truth.receivers[r].position_m;
    world.site.receivers[r].sigma_m.setZero();
  }
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 1e-5);
  EXPECT_NEAR(speed_mps(world.site.medium) + solution.state.speed_offset_mps[0],
              world.truth.speed_mps(world.site.medium.temperature_degC), 1e-5);
}

TEST(Solve, ErrorsAreWhatTheCovarianceSays) {
  double nees = 0.0, dof = 0.0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Scenario s = hall_scenario();
    s.path.epochs = 60;
    const World world = must(simulate(s, seed));
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, SolveStatus::kConverged) << "seed " << seed << ": " << solution.message;
    const BeaconErrors errors = beacon_errors(world, solution);
    nees += errors.nees();
    dof += static_cast<double>(errors.error.size());
  }
  // One run in ten thousand fails by chance; the curvature of the problem adds some per cent (as the external
  // gates allow).
  EXPECT_GT(nees, 0.85 * chi2_quantile(1e-4, dof));
  EXPECT_LT(nees, 1.15 * chi2_quantile(1 - 1e-4, dof));
}

// Poses assumed to be so inaccurate absorb all errors of the arrivals. Their noise would decrease to zero,
// and with it the sigmas of all later fixes.
TEST(Solve, PosesBetterThanStatedLeaveTheArrivalsTheirNoise) {
  for (const bool has_odometry : {true, false}) {
    Scenario s = drive_scenario(120.0);
    s.log_poses = true;
    s.pose_accuracy = {.position_sigma_m = 0.0, .heading_sigma_rad = 0.0};
    World world = must(simulate(s, 31));
    world.run.pose_accuracy = {.position_sigma_m = 0.01, .heading_sigma_rad = 0.01};
    if (!has_odometry) world.run.odometry.clear();
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
    EXPECT_NEAR(solution.tof_sigma_s / world.site.noise.tof_sigma_s, 1.0, 0.2) << has_odometry;
    EXPECT_THAT(solution.warnings, Contains(HasSubstr("measured poses fit")));
    world.run.pose_accuracy = {.position_sigma_m = 1e-4, .heading_sigma_rad = 1e-4};
    for (const std::string& warning : solution_of(world).warnings)
      EXPECT_THAT(warning, Not(HasSubstr("measured poses fit"))) << has_odometry;
  }
}

TEST(Solve, FixesOfACalibratedSiteAreWhatTheirCovarianceSays) {
  double nees = 0.0, dof = 0.0;
  for (std::uint64_t seed = 101; seed <= 140; ++seed) {
    Scenario s = hall_scenario();
    s.path.epochs = 30;
    s.heldout_path.epochs = 3;
    const World world = must(simulate(s, seed));
    const calib::Problem problem = problem_of(world);
    const calib::Solution solution = calib::solve(problem);
    if (solution.status != SolveStatus::kConverged)
      continue;  // thirty stops do not always reach the tolerance
    LeastSquaresLocalizer localizer(calib::make_deployment(problem, solution, {}));
    // One fix a world: those of one calibration share its errors.
    const std::vector<Fix> fixes = localizer.locate(world.heldout);
    ASSERT_FALSE(fixes.empty());
    if (!fixes[0].ok()) continue;
    const Eigen::Vector3d e = fix_error(world, fixes[0]);
    nees += e.dot(fixes[0].covariance.ldlt().solve(e));
    dof += 3.0;
  }
  EXPECT_GT(dof, 75.0);
  EXPECT_GT(nees, 0.85 * chi2_quantile(1e-4, dof));
  EXPECT_LT(
      nees,
      1.15 * chi2_quantile(1 - 1e-4,
                           dof));  // without the calibration's part it is 1.5 to 2 of the degrees of freedom
}

TEST(Solve, HeadingsDoNotFlipWhileTheBeaconsAreRough) {
  // Worlds in which beacons and flipped headings once kept each other wrong: errors of decimetres were
  // exported.
  for (const std::uint64_t seed : {2003, 2018, 2050, 2116, 2125, 2133, 2165, 2183}) {
    Scenario s = hall_scenario();
    s.path.epochs = 40;
    const World world = must(simulate(s, seed));
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, SolveStatus::kConverged) << "seed " << seed;
    EXPECT_LT(worst_beacon_m(world, solution), 0.03) << "seed " << seed;
    EXPECT_LT(solution.statistics.rejected, world.run.arrivals.size() / 100) << "seed " << seed;
  }
}

TEST(Solve, OrderOfRowsWithinAnEpochDoesNotMatter) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  World world = must(simulate(s, 3));
  const calib::Solution a = solution_of(world);
  std::mt19937 random(1);
  auto& rows = world.run.arrivals;
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t last = first;
    while (last < rows.size() && rows[last].epoch == rows[first].epoch) ++last;
    std::shuffle(rows.begin() + static_cast<std::ptrdiff_t>(first),
                 rows.begin() + static_cast<std::ptrdiff_t>(last), random);
    first = last;
  }
  const calib::Solution b = solution_of(world);
  for (std::size_t i = 0; i < a.state.beacon_p_map_m.size(); ++i)
    EXPECT_LT((a.state.beacon_p_map_m[i] - b.state.beacon_p_map_m[i]).norm(), 1e-6);
}

TEST(Solve, ARigidMotionOfTheWorldMovesTheAnswerWithIt) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  World world = must(simulate(s, 4));
  for (SiteBeacon& b : world.site.beacons)  // isotropic priors turn with the world
    EXPECT_EQ(*b.sigma_m[0], *b.sigma_m[1]);
  const calib::Solution a = solution_of(world);
  const Pose motion = Pose::planar(13.0, -7.0, 1.1);
  for (SiteBeacon& b : world.site.beacons) {
    const Eigen::Vector3d p = motion * Eigen::Vector3d(*b.position_m[0], *b.position_m[1], *b.position_m[2]);
    for (std::size_t i = 0; i < 3; ++i) b.position_m[i] = p[static_cast<Eigen::Index>(i)];
  }
  const calib::Solution b = solution_of(world);
  for (std::size_t i = 0; i < a.state.beacon_p_map_m.size(); ++i)
    EXPECT_LT((motion * a.state.beacon_p_map_m[i] - b.state.beacon_p_map_m[i]).norm(), 1e-5);
}

TEST(Solve, EchoesAreLeftOutAndListed) {
  Scenario s = hall_scenario();
  s.echo_fraction = 0.3;
  s.early_fraction = 0.01;
  const World world = must(simulate(s, 5));
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged);
  EXPECT_LT(worst_beacon_m(world, solution), 0.02);
  // If three beacons with two direct arrivals each and seven in all agree, an echo must not count as direct.
  std::map<std::int64_t, std::map<BeaconId, int>> direct;
  for (std::size_t i = 0; i < world.run.arrivals.size(); ++i)
    if (world.run_lateness_s[i] == 0.0) ++direct[world.run.arrivals[i].epoch][world.run.arrivals[i].beacon];
  const auto settled = [&](std::int64_t epoch) {
    int beacons = 0, arrivals = 0;
    for (const auto& [beacon, count] : direct[epoch]) {
      beacons += count > 1;
      arrivals += count;
    }
    return beacons >= 3 && arrivals >= 7;
  };
  std::set<std::size_t> out;
  for (const calib::LeftOut& l : solution.left_out)
    if (l.reason == Rejection::kLate) out.insert(l.arrival);
  std::size_t late = 0, listed = 0;
  for (std::size_t i = 0; i < world.run.arrivals.size(); ++i) {
    if (world.run_lateness_s[i] < 1e-4 || !settled(world.run.arrivals[i].epoch)) continue;
    ++late;
    listed += out.count(i);
  }
  EXPECT_GT(late, 100u);
  EXPECT_GT(static_cast<double>(listed), 0.98 * static_cast<double>(late));
  EXPECT_EQ(solution.statistics.arrivals + solution.statistics.rejected, world.run.arrivals.size());
}

TEST(Solve, ADriveIsCalibratedFromOdometryAndArrivals) {
  const World world = must(simulate(drive_scenario(90.0), 6));
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  const BeaconErrors errors = beacon_errors(world, solution);
  EXPECT_LT(errors.nees(), 1.15 * chi2_quantile(1 - 1e-4, static_cast<double>(errors.error.size())));
}

TEST(Solve, TwoWayRanging) {
  Scenario s = hall_scenario();
  s.site.timing.ranging = Ranging::kTwoWay;
  s.site.timing.turnaround_s = 0.01;
  const World world = must(simulate(s, 7));
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 0.02);
}

TEST(Solve, NothingKnownButTapesGivesAFreeNetwork) {
  Scenario s = hall_scenario();
  const auto at = [&](std::size_t b) {
    return Eigen::Vector3d(*s.site.beacons[b].position_m[0], *s.site.beacons[b].position_m[1],
                           *s.site.beacons[b].position_m[2]);
  };
  for (const auto& [i, j] : {std::pair<std::size_t, std::size_t>{0, 4}, {2, 6}})
    s.site.distances.push_back({BeaconId(i), BeaconId(j), (at(i) - at(j)).norm(), 0.003});
  World world = must(simulate(s, 8));
  for (SiteBeacon& b : world.site.beacons) {
    b.position_m = {};
    b.sigma_m = {};
  }
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  EXPECT_THAT(solution.datum.position, HasSubstr("inner constraints"));
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_GT(solution.state.beacon_p_map_m[i].z(), 0.3);
    for (std::size_t j = 0; j < i; ++j) {
      const double truth_m = (world.truth.beacons[i].position_m - world.truth.beacons[j].position_m).norm();
      EXPECT_NEAR((solution.state.beacon_p_map_m[i] - solution.state.beacon_p_map_m[j]).norm(), truth_m,
                  0.02);
    }
  }
  // Inner constraints: the covariance contains no motions of the whole.
  double translation = 0.0;
  for (std::size_t i = 0; i < solution.covariance.parameters.size(); ++i)
    for (std::size_t j = 0; j < solution.covariance.parameters.size(); ++j) {
      const auto is_x = [&](std::size_t k) {
        const ParameterId& id = solution.covariance.parameters[k];
        return id.kind == ParameterKind::kBeaconPosition && id.component == 0;
      };
      if (is_x(i) && is_x(j))
        translation += solution.covariance.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  EXPECT_LT(std::abs(translation), 1e-9);
}

TEST(Solve, ExchangedBeaconsAreRecoveredAndNamed) {
  World world = must(simulate(hall_scenario(), 9));
  std::swap(world.site.beacons[1].position_m, world.site.beacons[4].position_m);
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 0.02);
  EXPECT_THAT(solution.warnings,
              Contains(testing::AllOf(HasSubstr("B1"), HasSubstr("B4"), HasSubstr("exchanged"))));
}

TEST(Solve, ABeaconThatWasNotHeardDoesNotBlockTheOthers) {
  World world = must(simulate(hall_scenario(), 10));
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return a.beacon == BeaconId(2); });
  world.run_lateness_s.clear();
  calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged);
  EXPECT_EQ(solution.beacon_status[2], BeaconStatus::kUndetermined);
  EXPECT_THAT(solution.warnings, Contains(HasSubstr("B2")));
  EXPECT_LT((solution.state.beacon_p_map_m[1] - world.truth.beacons[1].position_m).norm(), 0.02);
  EXPECT_EQ(solution_of(world, {.strict = true}).status, SolveStatus::kUndetermined);
}

TEST(Solve, WithoutAnyLengthTheScaleIsRefused) {
  World world = must(simulate(hall_scenario(), 11));
  world.site.speed_sigma_mps = 100.0;
  for (SiteReceiver& r : world.site.receivers) r.sigma_m.setConstant(0.5);
  for (SiteBeacon& b : world.site.beacons) {
    b.position_m = {};
    b.sigma_m = {};
  }
  const calib::Solution solution = solution_of(world);
  EXPECT_EQ(solution.status, SolveStatus::kUndetermined);
  EXPECT_THAT(solution.message, HasSubstr("scale"));
  EXPECT_THAT(solution.undetermined, Contains("medium/speed_mps"));
}

TEST(Solve, ADelayThatTheDataDoNotSupportLeavesTheBeacons) {
  Scenario s = hall_scenario();
  s.site.timing.delay_per = {};
  s.site.timing.delay_s = s.site.timing.delay_sigma_s = 0.0;
  s.true_delay_s.reset();
  World world = must(simulate(s, 12));
  const calib::Solution without = solution_of(world);
  world.site.timing.delay_per.receiver = true;
  world.site.timing.delay_sigma_s = 1e-5;
  const calib::Solution with = solution_of(world);
  ASSERT_EQ(with.status, SolveStatus::kConverged) << with.message;
  for (std::size_t b = 0; b < 8; ++b)
    EXPECT_LT((with.state.beacon_p_map_m[b] - without.state.beacon_p_map_m[b]).norm(), 0.01);
}

TEST(Solve, TheLastStageComesToRestWithFourTimesTheIterations) {
  const World world = must(simulate(hall_scenario(), 1));
  calib::SolveOptions options;
  options.max_iterations = 2;  // of the stages on the way; the last one needs six
  const calib::Solution solution = solution_of(world, options);
  EXPECT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
}

TEST(Solve, StopsWhenToldTo) {
  const World world = must(simulate(hall_scenario(), 13));
  int calls = 0;
  calib::SolveOptions options;
  options.on_progress = [&](const calib::Progress&) { return ++calls < 5; };
  EXPECT_EQ(solution_of(world, options).status, SolveStatus::kInterrupted);
  EXPECT_LT(calls, 8);
}

TEST(Solve, ThreadsDoNotChangeTheAnswer) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  const World world = must(simulate(s, 14));
  const calib::Solution one = solution_of(world, {.threads = 1}), two = solution_of(world, {.threads = 2});
  for (std::size_t b = 0; b < 8; ++b)
    EXPECT_LT((one.state.beacon_p_map_m[b] - two.state.beacon_p_map_m[b]).norm(), 1e-9);
}

}  // namespace solve_test
}  // namespace octant::test
