// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/evaluate.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

namespace octant::survey {
namespace evaluate_test {

Fix fix_at(double time_s, const Pose& pose) {
  Fix fix;
  fix.status = FixStatus::kOk;
  fix.time_s = time_s;
  fix.T_map_vehicle = pose;
  fix.covariance = 1.0e-4 * Eigen::Matrix3d::Identity();
  return fix;
}

const std::vector<TimedPose> kStraight = {
    {10.0, Pose::planar(0, 0, 0)}, {10.5, Pose::planar(1, 0, 0)}, {11.0, Pose::planar(2, 0, 0)}};
const PoseAccuracy kExact = {.position_sigma_m = 0.0, .heading_sigma_rad = 0.0};

TEST(Evaluate, ClosedFormFigures) {
  // Offsets of 3, 4 and 0 mm: RMSE sqrt(25/3), and p95 interpolated between the two largest of three: 3 + 0.9
  // (4 - 3).
  const std::vector<Fix> fixes = {fix_at(10.0, Pose::planar(0.003, 0, 0.1)),
                                  fix_at(10.5, Pose::planar(1, 0.004, -0.1)),
                                  fix_at(11.0, Pose::planar(2, 0, 0.1))};
  const Evaluation e = evaluate(fixes, kStraight, kExact, Motion::kPlanar, {.beacon_m = {}, .fix_m = 0.0029});
  EXPECT_EQ(e.fixes, 3u);
  EXPECT_EQ(e.matched, 3u);
  EXPECT_NEAR(e.position_rmse_m, std::sqrt(25.0 / 3) * 1e-3, 1e-12);
  EXPECT_NEAR(e.position_p95_m, 3.9e-3, 1e-12);
  EXPECT_NEAR(e.max_error_m, 4e-3, 1e-12);
  ASSERT_TRUE(e.heading_rmse_rad);
  EXPECT_NEAR(*e.heading_rmse_rad, 0.1, 1e-12);
  // (25 mm^2 + 3 x 0.01 rad^2) / 1e-4 over 3 degrees of freedom and 3 fixes.
  ASSERT_TRUE(e.nees_mean);
  EXPECT_NEAR(*e.nees_mean, (25e-6 + 0.03) / 1e-4 / 9, 1e-6);
  ASSERT_EQ(e.gates.size(), 1u);
  EXPECT_EQ(e.gates[0].name, "fix_m");
  EXPECT_TRUE(e.pass()) << e.gates[0].value;
}

/// Two floors 3 m apart: errors of 3 mm below and 4 mm above, where one of two epochs has no fix.
TEST(Evaluate, EachFloorByItself) {
  const auto at = [](double x_m, double z_m) { return Pose{{x_m, 0, z_m}, Eigen::Quaterniond::Identity()}; };
  const std::vector<TimedPose> truth = {
      {10.0, at(0, 0.4)}, {10.5, at(1, 0.4)}, {20.0, at(0, 3.4)}, {20.5, at(1, 3.4)}};
  Fix none;
  none.time_s = 20.5;
  const std::vector<Fix> fixes = {fix_at(10.0, at(0.003, 0.4)), fix_at(10.5, at(1.003, 0.4)),
                                  fix_at(20.0, at(0.004, 3.4)), none};
  const Evaluation e = evaluate(fixes, truth, kExact, Motion::kPlanar, {});
  ASSERT_EQ(e.floors.size(), 2U);
  EXPECT_EQ(e.floors[0].name, "0.4 m");
  EXPECT_EQ(e.floors[1].name, "3.4 m");
  EXPECT_NEAR(e.floors[0].errors.rmse_m, 0.003, 1e-12);
  EXPECT_NEAR(e.floors[1].errors.rmse_m, 0.004, 1e-12);
  EXPECT_EQ(e.floors[1].no_fix, 1U);
  EXPECT_EQ(e.floors[0].availability, 1.0);
  EXPECT_EQ(e.floors[1].availability, 0.5);
  EXPECT_TRUE(evaluate(fixes, kStraight, kExact, Motion::kPlanar, {}).floors.empty()) << "one floor";
}

TEST(Evaluate, GateFailsAndNoToleranceHasNoGate) {
  const std::vector<Fix> fixes = {fix_at(10.0, Pose::planar(0.01, 0, 0))};
  EXPECT_FALSE(evaluate(fixes, kStraight, kExact, Motion::kPlanar, {.beacon_m = {}, .fix_m = 0.009}).pass());
  EXPECT_TRUE(evaluate(fixes, kStraight, kExact, Motion::kPlanar, {.beacon_m = {}, .fix_m = 0.01}).pass());
  EXPECT_TRUE(evaluate(fixes, kStraight, kExact, Motion::kPlanar, {}).gates.empty());
}

TEST(Evaluate, InterpolatesBetweenSamples) {
  const Evaluation e =
      evaluate({fix_at(10.75, Pose::planar(1.5, 0, 0))}, kStraight, kExact, Motion::kPlanar, {});
  EXPECT_EQ(e.matched, 1u);
  EXPECT_NEAR(e.max_error_m, 0.0, 1e-12);
}

TEST(Evaluate, TurnsTheShortWay) {
  const std::vector<TimedPose> truth = {{0.0, Pose::planar(0, 0, 3.1)}, {1.0, Pose::planar(0, 0, -3.1)}};
  const Evaluation e = evaluate({fix_at(0.5, Pose::planar(0, 0, -M_PI))}, truth, kExact, Motion::kPlanar, {});
  EXPECT_NEAR(e.heading_rmse_rad.value(), 0.0, 1e-9);
}

TEST(Evaluate, NeverBeyondTheEndsNorOverGaps) {
  const Pose here = Pose::planar(0, 0, 0);
  EXPECT_EQ(
      evaluate({fix_at(9.99, here), fix_at(11.01, here)}, kStraight, kExact, Motion::kPlanar, {}).matched,
      0u);
  // A time within rounding error of the last sample is that sample.
  EXPECT_EQ(
      evaluate({fix_at(11.0 + 1e-9, here), fix_at(10.0 - 1e-9, here)}, kStraight, kExact, Motion::kPlanar, {})
          .matched,
      2u);
  const std::vector<TimedPose> sparse = {{0.0, here}, {100.0, Pose::planar(0.01, 0, 0)}};
  EXPECT_EQ(evaluate({fix_at(0.0, here), fix_at(50.0, here), fix_at(100.0, here)}, sparse, kExact,
                     Motion::kPlanar, {})
                .matched,
            2u);
}

TEST(Evaluate, AVehicleThatStandsHasAReferenceHoweverSeldomItIsRead) {
  const Pose here = Pose::planar(3, 2, 1);
  const std::vector<TimedPose> stops = {
      {0.0, here}, {60.0, here}, {500.0, Pose::planar(9, 2, 1)}, {560.0, Pose::planar(9, 2, 1)}};
  EXPECT_EQ(evaluate({fix_at(30.0, here), fix_at(250.0, here), fix_at(530.0, here)}, stops, kExact,
                     Motion::kPlanar, {})
                .matched,
            2u);
}

TEST(Evaluate, NothingMatchedNeverPasses) {
  const Evaluation e = evaluate({fix_at(99.0, Pose{})}, kStraight, kExact, Motion::kPlanar, {});
  EXPECT_EQ(e.matched, 0u);
  EXPECT_FALSE(e.pass());
  EXPECT_FALSE(e.nees_mean);
  EXPECT_FALSE(e.heading_rmse_rad);
  EXPECT_FALSE(evaluate(std::vector<Fix>{}, {}, kExact, Motion::kPlanar, {}).pass());
}

TEST(Evaluate, CountsEpochsWithoutFix) {
  Fix none;
  none.time_s = 10.0;
  const Evaluation e =
      evaluate({none, fix_at(10.0, Pose::planar(0, 0, 0))}, kStraight, kExact, Motion::kPlanar, {});
  EXPECT_EQ(e.no_fix, 1u);
  EXPECT_EQ(e.fixes, 1u);
}

TEST(Evaluate, UnknownHeadingLeavesTheHeadingOut) {
  PoseAccuracy accuracy = kExact;
  accuracy.heading_known = false;
  const Evaluation e =
      evaluate({fix_at(10.0, Pose::planar(0.01, 0, 2.0))}, kStraight, accuracy, Motion::kPlanar, {});
  EXPECT_FALSE(e.heading_rmse_rad);
  EXPECT_NEAR(e.nees_mean.value(), 0.5, 1e-9);  // one sigma in x, two degrees of freedom
}

TEST(Evaluate, SingularCovarianceGivesNoNees) {
  Fix fix = fix_at(10.0, Pose::planar(0, 0, 0));
  fix.covariance.setZero();
  EXPECT_FALSE(evaluate({fix}, kStraight, kExact, Motion::kPlanar, {}).nees_mean);
  fix.covariance = Eigen::MatrixXd();
  EXPECT_FALSE(evaluate({fix}, kStraight, kExact, Motion::kPlanar, {}).nees_mean);
}

TEST(Evaluate, SpatialErrorIsInSpace) {
  const std::vector<TimedPose> truth = {{0.0, Pose{}}};
  Fix fix = fix_at(0.0, Pose{{0.0, 0.003, 0.004}, Eigen::Quaterniond::Identity()});
  fix.covariance = Eigen::MatrixXd::Identity(6, 6);
  EXPECT_NEAR(evaluate({fix}, truth, kExact, Motion::kSpatial, {}).max_error_m, 0.005, 1e-12);
  EXPECT_NEAR(evaluate({fix}, truth, kExact, Motion::kPlanar, {}).max_error_m, 0.003, 1e-12);
}

Fix in_space_at(double time_s, const Eigen::Vector3d& p) {
  Fix fix = fix_at(time_s, Pose{p, Eigen::Quaterniond::Identity()});
  fix.covariance = 1e-4 * Eigen::MatrixXd::Identity(6, 6);
  return fix;
}

// ISO/IEC 18305: horizontal errors 0, 3 and 4 mm, vertical 0, 4 and 3 mm.
TEST(Evaluate, CircularVerticalAndSphericalErrors) {
  const std::vector<Fix> fixes = {in_space_at(10.0, {0, 0, 0}), in_space_at(10.5, {1, 0.003, 0.004}),
                                  in_space_at(11.0, {2.004, 0, -0.003})};
  const ErrorFigures e = evaluate(fixes, kStraight, kExact, Motion::kSpatial, {}).errors;
  EXPECT_NEAR(e.mean_m, 10e-3 / 3, 1e-12);
  EXPECT_NEAR(e.rmse_m, std::sqrt(50.0 / 3) * 1e-3, 1e-12);
  EXPECT_NEAR(e.ce50_m, 3e-3, 1e-12);
  EXPECT_NEAR(e.ce95_m, 3.9e-3, 1e-12);
  EXPECT_NEAR(e.ve95_m.value(), 3.9e-3, 1e-12);
  EXPECT_NEAR(e.se95_m.value(), 5e-3, 1e-12);
  EXPECT_FALSE(evaluate(fixes, kStraight, kExact, Motion::kPlanar, {}).errors.ve95_m);
}

TEST(Evaluate, AvailabilityIsOfTheEpochsCoverageOfTheReference) {
  Fix none;
  none.time_s = 10.5;
  ReferencedRun run = {{fix_at(10.0, Pose{}), none}, kStraight, kExact, "east"};
  run.truth_accuracy.max_gap_s = 0.6;
  const Evaluation e = evaluate({run}, Motion::kPlanar, {});
  ASSERT_EQ(e.runs.size(), 1U);
  EXPECT_EQ(e.runs[0].name, "east");
  EXPECT_DOUBLE_EQ(e.availability, 0.5);
  EXPECT_NEAR(e.coverage, 2.0 / 3, 1e-12) << "of 10.0 and 10.5 s, not of 11.0 s";
  EXPECT_DOUBLE_EQ(e.runs[0].coverage, e.coverage);
}

// A single antenna two metres before the origin: its fixes are compared at the antenna.
TEST(Evaluate, FixesOfAnOpenAttitudeAreComparedAtThePointThatTheyLocate) {
  const Eigen::Vector3d antenna_m(2, 0, 0);
  Fix fix = in_space_at(10.0, {0.01, 2, 0});
  fix.covariance.diagonal().head<3>().array() += 4.0 / 3;
  fix.covariance.diagonal().tail<3>().setConstant(kUnknownRotationVariance);
  ReferencedRun run = {{fix}, {{10.0, Pose::planar(0, 0, std::numbers::pi / 2)}}, kExact};
  run.p_located_vehicle_m = antenna_m;
  const Evaluation e = evaluate({run}, Motion::kSpatial, {});
  EXPECT_NEAR(e.position_rmse_m, 0.01, 1e-12);
  EXPECT_NEAR(e.nees_mean.value(), 1.0 / 3, 1e-9);
  EXPECT_FALSE(e.heading_rmse_rad);
  run.truth_accuracy.heading_known = false;
  const Evaluation open = evaluate({run}, Motion::kSpatial, {});
  EXPECT_NEAR(open.position_rmse_m, 2.0, 1e-3);
  EXPECT_NEAR(open.nees_mean.value(), 4.0 / (3 * 1.3334), 1e-2);
}

TEST(Evaluate, RunsTogetherAreOneSample) {
  const ReferencedRun one = {{fix_at(10.0, Pose::planar(0.003, 0, 0))}, kStraight, kExact};
  const ReferencedRun two = {{fix_at(10.0, Pose::planar(0, 0.004, 0))}, kStraight, kExact};
  const Evaluation e = evaluate({one, two}, Motion::kPlanar, {});
  EXPECT_EQ(e.matched, 2u);
  EXPECT_NEAR(e.position_rmse_m, std::sqrt(12.5) * 1e-3, 1e-12);
}

/// Quantile of chi-square over its degrees of freedom, Wilson and Hilferty; 0.1 % exact at the sizes used
/// here.
double chi2_over_dof(double z, double dof) {
  return std::pow(1 - 2 / (9 * dof) + z * std::sqrt(2 / (9 * dof)), 3);
}

void expect_honest_nees(Motion motion, bool heading_known, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const int n = pose_dof(motion), count = 4000;
  const auto draw = [&](int rows) {
    return Eigen::VectorXd::NullaryExpr(rows, [&] { return normal(random); }).eval();
  };
  const PoseAccuracy accuracy = {.position_sigma_m = 0.004,
                                 .heading_sigma_rad = 0.003,
                                 .heading_known = heading_known,
                                 .attitude_sigma_rad = 0.002};
  std::vector<Fix> fixes;
  std::vector<TimedPose> truth;
  for (int i = 0; i < count; ++i) {
    const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    const Eigen::MatrixXd C = 1e-5 * (A * A.transpose() + Eigen::MatrixXd::Identity(n, n));
    Eigen::VectorXd pose = draw(n);
    const Pose T_true = retract(Pose{}, pose, motion);
    Fix fix = fix_at(
        i, retract(T_true, Eigen::VectorXd(Eigen::LLT<Eigen::MatrixXd>(C).matrixL() * draw(n)), motion));
    fix.covariance = C;
    Eigen::VectorXd noise = draw(n);
    noise.head(motion == Motion::kPlanar ? 2 : 3) *= accuracy.position_sigma_m;
    if (motion == Motion::kPlanar) {
      noise[2] *= accuracy.heading_sigma_rad;
    } else {  // about the map's axes, then into the vehicle frame
      const Eigen::Vector3d about_map = noise.tail<3>().cwiseProduct(Eigen::Vector3d(
          accuracy.attitude_sigma_rad, accuracy.attitude_sigma_rad, accuracy.heading_sigma_rad));
      noise.tail<3>() = T_true.rotation.conjugate() * about_map;
    }
    truth.push_back({double(i), retract(T_true, noise, motion)});
    fixes.push_back(fix);
  }
  const double dof = double(count) * (heading_known ? n : n == 3 ? 2 : 3);
  const double nees = evaluate(fixes, truth, accuracy, motion, {}).nees_mean.value();
  // Two-sided at 4 sigma (6e-5): a fixed seed, so that a failure is a change of the code.
  EXPECT_GT(nees, chi2_over_dof(-4.0, dof)) << "seed " << seed;
  EXPECT_LT(nees, chi2_over_dof(4.0, dof)) << "seed " << seed;
}

TEST(Evaluate, NeesOfHonestCovariancesIsChiSquare) {
  expect_honest_nees(Motion::kPlanar, true, 1);
  expect_honest_nees(Motion::kPlanar, false, 2);
  expect_honest_nees(Motion::kSpatial, true, 3);
  expect_honest_nees(Motion::kSpatial, false, 4);
}

TEST(BeaconErrors, OnlyBeaconsThatWereSolvedFor) {
  Deployment found, truth;
  const auto add = [](Deployment& d, const char* name, double x_m, BeaconStatus status) {
    DeploymentBeacon beacon;
    beacon.name = name;
    beacon.position_m.x() = x_m;
    beacon.status = status;
    d.beacons.push_back(beacon);
  };
  add(found, "B0", 0.0, BeaconStatus::kControlPoint);
  add(found, "B1", 1.002, BeaconStatus::kCalibrated);
  add(found, "B2", 7.0, BeaconStatus::kUndetermined);
  add(found, "B3", 3.0, BeaconStatus::kCalibrated);
  add(truth, "B1", 1.0, BeaconStatus::kCalibrated);
  add(truth, "B2", 2.0, BeaconStatus::kCalibrated);
  const auto errors = beacon_errors(found, truth);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors[0].name, "B1");
  EXPECT_NEAR(errors[0].error_m, 0.002, 1e-12);
}

}  // namespace evaluate_test
}  // namespace octant::survey
