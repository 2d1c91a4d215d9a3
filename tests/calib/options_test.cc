// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Parameters that a site switches on: the drift of a clock, the array as one piece, a motion prior,
// directional receivers.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/linearise.h"
#include "tests/calib/calib_support.h"
#include "tests/support/statistics.h"

namespace octant::test {
namespace options_test {

Scenario drifting_hall() {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  // With one firing of each beacon in each cycle, a drift resembles a delay of each beacon. The second firing
  // distinguishes them.
  s.path.rounds = 2;
  s.site.timing.clock = Clock::kCycleOffset;
  s.site.timing.delay_per = {};
  s.site.timing.drift_sigma = 100e-6;
  s.true_delay_s.reset();
  return s;
}

// 100 ppm over a cycle of 0.8 s are 27 mm: visible in every epoch, and the beacons are wrong without a
// correction.
TEST(ClockDrift, IsCalibratedWithinItsSigma) {
  double squares = 0.0;
  const int seeds = 5;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const World world = must(simulate(drifting_hall(), seed));
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
    const double sigma = sigma_of(solution, world.site, "vehicle/robot/clock_drift");
    EXPECT_LT(sigma, 5e-6);
    squares += std::pow((solution.state.clock_drift.at(0) - world.truth.vehicles[0].clock_drift) / sigma, 2);
    EXPECT_LT(worst_beacon_m(world, solution), 0.03) << seed;
    EXPECT_GT(solution.statistics.chi2_p, 1e-4);
  }
  EXPECT_LT(squares, 20.5);  // chi-square of five degrees of freedom, 99.9 %
}

TEST(ClockDrift, LeftOutItShowsInTheVarianceFactor) {
  const World world = must(simulate(drifting_hall(), 1));
  ASSERT_GT(std::abs(world.truth.vehicles[0].clock_drift), 30e-6);
  calib::Problem problem = problem_of(world);
  problem.site.timing.drift_sigma = 0.0;
  EXPECT_GT(calib::solve(problem, {}).statistics.variance_factor, 1.3);
}

TEST(ClockDrift, TheLocalizerTakesItOut) {
  World world = must(simulate(drifting_hall(), 1));
  const auto rmse_m = [&](const Deployment& deployment) {
    double squares = 0.0;
    int count = 0;
    for (const Fix& fix : LeastSquaresLocalizer(deployment).locate(world.heldout)) {
      if (!fix.ok()) continue;
      Pose truth;
      if (!interpolate_poses(world.heldout.truth, fix.time_s, 1.0, truth)) continue;
      squares += (fix.T_map_vehicle.translation_m - truth.translation_m).squaredNorm();
      ++count;
    }
    return std::sqrt(squares / std::max(count, 1));
  };
  const double with_m = rmse_m(world.truth);
  world.truth.vehicles[0].clock_drift = 0.0;
  EXPECT_LT(with_m, 0.006);  // its bound is 4 mm
  EXPECT_GT(rmse_m(world.truth), 1.3 * with_m);
}

Scenario turned_array() {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  for (SiteReceiver& r : s.site.receivers) r.sigma_m.setZero();
  s.site.vehicles[0].array = ArrayShape{0.003, 0.05};
  return s;
}

// The rotation of the array in the vehicle needs a reference for the vehicle's heading: measured poses. One
// beacon of the hall is new: its data sheet has another delay and its accuracy.
TEST(BeaconDelay, ItsOwnPriorActsInPlaceOfTimings) {
  Scenario s = hall_scenario();
  s.path.epochs = 20;
  s.site.timing.delay_sigma_s = 2e-5;
  s.site.beacons[4].delay_s = 9e-4;
  s.site.beacons[4].delay_sigma_s = 1e-7;
  World world = must(simulate(s, 3));
  EXPECT_NEAR(world.truth.beacons[4].delay_s, 9e-4, 4e-7) << "drawn from its own prior";
  const calib::Solution own = solution_of(world);
  ASSERT_EQ(own.status, calib::SolveStatus::kConverged) << own.message;
  EXPECT_LT(sigma_of(own, world.site, "beacon/B4/delay_s"), 1.01e-7) << "no wider than its prior";
  EXPECT_NEAR(own.state.beacon_delay_s[4], 9e-4, 1e-6);
  EXPECT_GT(sigma_of(own, world.site, "beacon/B5/delay_s"), 5e-7) << "of the others timing's holds";
  EXPECT_TRUE(own.contradictions.empty());

  // With timing's prior only, 1e-4 +- 2e-5, this beacon contradicts the site file.
  world.site.beacons[4].delay_s = world.site.beacons[4].delay_sigma_s = std::nullopt;
  const calib::Solution by_timing = solution_of(world);
  ASSERT_FALSE(by_timing.contradictions.empty());
  EXPECT_EQ(by_timing.contradictions[0].subject, "B4");
}

TEST(BeaconDelay, ZeroSigmaHoldsOneBeaconsDelayAlone) {
  Scenario s = hall_scenario();
  s.path.epochs = 20;
  s.site.beacons[4].delay_s = 9e-4;
  s.site.beacons[4].delay_sigma_s = 0.0;
  const World world = must(simulate(s, 4));
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  EXPECT_EQ(solution.state.beacon_delay_s[4], 9e-4);
  EXPECT_THAT(solution.covariance.parameters, testing::Not(testing::Contains(parameters::beacon_delay(4))));
  EXPECT_THAT(solution.covariance.parameters, testing::Contains(parameters::beacon_delay(5)));
}

TEST(ArrayShape, RadiusAndTurnAreCalibratedWithinTheirSigmas) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Scenario s = turned_array();
    s.log_poses = true;
    s.pose_accuracy = {.position_sigma_m = 0.005, .heading_sigma_rad = 0.01};
    const World world = must(simulate(s, seed));
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
    const Eigen::Vector3d o = solution.state.receiver_p_vehicle_m[0],
                          o_true = world.truth.receivers[0].position_m;
    const double radius_sigma_m = sigma_of(solution, world.site, "array/robot/radius_m"),
                 turn_sigma_rad = sigma_of(solution, world.site, "array/robot/turn_rad");
    EXPECT_LT(radius_sigma_m, 0.001);
    EXPECT_LT(turn_sigma_rad, 0.005);
    squares += std::pow((o.head<2>().norm() - o_true.head<2>().norm()) / radius_sigma_m, 2);
    squares += std::pow(
        wrap_angle(std::atan2(o.y(), o.x()) - std::atan2(o_true.y(), o_true.x())) / turn_sigma_rad, 2);
    // The deployment states them by receiver: across the radius by the turn, along it by the radius.
    const Deployment d = calib::make_deployment(problem_of(world), solution, {});
    EXPECT_NEAR(d.receivers[0].sigma_m.x(), radius_sigma_m, 0.05 * radius_sigma_m);
    EXPECT_NEAR(d.receivers[0].sigma_m.y(), o.head<2>().norm() * turn_sigma_rad,
                0.05 * o.head<2>().norm() * turn_sigma_rad);
  }
  EXPECT_LT(squares, 22.5);  // chi-square of six degrees of freedom, 99.9 %
}

TEST(ArrayShape, TwoUnknownsStandForAll) {
  const World world = must(simulate(turned_array(), 1));
  const calib::Solution solution = solution_of(world);
  int shape = 0, single = 0;
  for (const ParameterId& id : solution.covariance.parameters) {
    shape += id.kind == ParameterKind::kArray;
    single += id.kind == ParameterKind::kReceiverPosition;
  }
  EXPECT_EQ(shape, 2);
  EXPECT_EQ(single, 0);
}

Scenario driven_hall() {
  Scenario s = drive_scenario(90.0);
  s.site.vehicles[0].motion = MotionPrior{0.8, 0.8, 0.8, 1.5};
  return s;
}

World without_odometry(std::uint64_t seed) {
  World world = must(simulate(driven_hall(), seed));
  world.run.odometry.clear();
  world.heldout.odometry.clear();
  return world;
}

TEST(MotionPrior, CarriesADriveWithoutOdometry) {
  const World world = without_odometry(1);
  const calib::Problem problem = problem_of(world);
  ASSERT_TRUE(problem.trajectories.at(0).motion_prior.has_value());
  const calib::Solution solution = calib::solve(problem, {});
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 0.05);
  const BeaconErrors errors = beacon_errors(world, solution);
  EXPECT_LT(errors.nees(), 2.0 * static_cast<double>(errors.error.size()));
}

TEST(MotionPrior, TracksWithHonestSigmas) {
  const World world = without_odometry(2);
  double squares_m2 = 0.0, nees = 0.0;
  int count = 0;
  for (const Fix& fix : track(world.heldout, world.truth)) {
    if (!fix.ok()) continue;
    Pose truth;
    if (!interpolate_poses(world.heldout.truth, fix.time_s, 1.0, truth)) continue;
    const Eigen::Vector2d off = (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>();
    squares_m2 += off.squaredNorm();
    nees += off.dot(Eigen::Matrix2d(fix.covariance.topLeftCorner<2, 2>()).ldlt().solve(off)) / 2;
    ++count;
  }
  ASSERT_GT(count, 300);
  EXPECT_LT(std::sqrt(squares_m2 / count), 0.01);
  EXPECT_LT(nees / count, 1.5);
  EXPECT_GT(nees / count, 0.3);  // a prior is no model of this vehicle: on straights it is too wide
}

// Rows of the prior against finite differences.
TEST(MotionPrior, DerivativesMatchNumericOnes) {
  const World world = without_odometry(3);
  calib::Problem problem = problem_of(world);
  Trajectory& t = problem.trajectories.at(0);
  for (std::size_t k = 0; k < 3; ++k) {
    t.nodes[k].T_map_vehicle =
        Pose::planar(1.0 + 0.1 * static_cast<double>(k), 2.0, 0.3 - 0.2 * static_cast<double>(k));
    t.nodes[k].velocity = {0.4, -0.2, 0.7 * static_cast<double>(k)};
  }
  for (std::size_t index = 0; index < 3; ++index) {
    ObservationRow rows[6];
    const int count = motion_rows(t, index, rows);
    ASSERT_EQ(count, index == 0 ? 4 : 6);
    for (int column = 0; column < 6; ++column)
      for (const bool next : {false, true}) {
        if (next && t.motion_steps[index].step_s == 0) continue;
        const double step = 1e-6;
        Trajectory moved = t;
        Node& node = moved.nodes[t.motion_steps[index].node + (next ? 1 : 0)];
        if (column < 3)
          node.T_map_vehicle =
              retract(node.T_map_vehicle, step * Eigen::Vector3d::Unit(column), Motion::kPlanar);
        else
          node.velocity[column - 3] += step;
        ObservationRow there[6];
        motion_rows(moved, index, there);
        for (int i = 0; i < count; ++i) {
          if (index == 0 && i == 0) continue;  // the open heading has no residual
          const double analytic = next ? rows[i].by_next[column] : rows[i].by_node[column];
          EXPECT_NEAR((there[i].residual - rows[i].residual) / step, analytic,
                      1e-5 * (1 + std::abs(analytic)))
              << index << " " << i << " " << column;
        }
      }
  }
}

/// The array's directivity is calibrated from amplitudes with everything else. Compared with the same logs
/// calibrated for omnidirectional receivers, in which arrivals off the axis appear late.
TEST(Directivity, IsCalibratedFromAmplitudes) {
  double nees = 0.0, dof = 0.0, squares = 0.0, squares_blind = 0.0;
  for (std::uint64_t seed = 5; seed <= 12; ++seed) {
    Scenario s = hall_scenario();
    s.path.epochs = seed > 5 ? 60 : 30;  // what fits so badly takes its time
    add_attenuation(s);
    s.hearing_half_angle_rad = 3.2;
    s.log_amplitude = true;
    s.site.attenuation->half_power_angle_rad = {0.5, 0.1};
    s.site.attenuation->saturation_v = 5.0;
    World world = must(simulate(s, seed));
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << "seed " << seed << ": " << solution.message;
    const double error =
        solution.state.attenuation->half_power_angle_rad - world.truth.attenuation->half_power_angle_rad;
    const double sigma = sigma_of(solution, world.site, "attenuation/half_power_angle_rad");
    EXPECT_LT(sigma, 0.005) << "a tenth of a radian beforehand";
    const BeaconErrors errors = beacon_errors(world, solution);
    nees += errors.nees() + error * error / (sigma * sigma);
    dof += 1 + static_cast<double>(errors.error.size());
    EXPECT_LT(solution.statistics.rejected, 10u)
        << "seed " << seed << ": weak arrivals are late by what their amplitude says, and no echoes";
    if (seed > 5) continue;
    squares += errors.error.squaredNorm();
    world.site.attenuation->half_power_angle_rad = {};
    const calib::Solution blind = solution_of(world);
    EXPECT_THAT(blind.warnings, testing::Contains(testing::HasSubstr("attenuation.half_power_angle_rad")));
    squares_blind += beacon_errors(world, blind).error.squaredNorm();
  }
  // One run in ten thousand fails by chance; the curvature of the problem adds some per cent.
  EXPECT_GT(nees, 0.85 * chi2_quantile(1e-4, dof));
  EXPECT_LT(nees, 1.15 * chi2_quantile(1 - 1e-4, dof));
  EXPECT_LT(25 * squares, squares_blind) << "five times the error";
}

/// Fixes use the results of the calibration: in time and in amplitude, including the walk off the axis.
TEST(Directivity, ServesTheFixes) {
  double nees = 0.0, dof = 0.0;
  for (std::uint64_t seed = 21; seed <= 32; ++seed) {
    Scenario s = hall_scenario();
    s.path.epochs = 60;
    s.heldout_path.epochs = 10;
    add_attenuation(s);
    s.hearing_half_angle_rad = 3.2;
    s.log_amplitude = true;
    s.site.attenuation->half_power_angle_rad = {0.5, 0.1};
    const World world = must(simulate(s, seed));
    const calib::Problem problem = problem_of(world);
    const calib::Solution solution = calib::solve(problem);
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << "seed " << seed;
    const Deployment d = calib::make_deployment(problem, solution, {});
    EXPECT_TRUE(d.attenuation->directional());
    LeastSquaresLocalizer localizer(d);
    const std::vector<Fix> fixes = localizer.locate(world.heldout);
    ASSERT_EQ(fixes.size(), 10u);
    for (const Fix& fix : fixes) {
      ASSERT_TRUE(fix.ok()) << to_string(fix.status);
      const Eigen::Vector3d e = fix_error(world, fix);
      EXPECT_LT(std::abs(e.z()), 0.02) << "a degree";
      if (&fix != &fixes[0]) continue;  // those of one calibration share its errors
      nees += e.dot(fix.covariance.ldlt().solve(e));
      dof += 3.0;
    }
  }
  EXPECT_GT(nees, 0.85 * chi2_quantile(1e-4, dof));
  EXPECT_LT(nees, 1.15 * chi2_quantile(1 - 1e-4, dof));
}

}  // namespace options_test
}  // namespace octant::test
