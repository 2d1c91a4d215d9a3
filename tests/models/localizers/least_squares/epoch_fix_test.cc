// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/epoch_fix.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/LU>

#include "tests/models/localizers/hall.h"
#include "tests/support/statistics.h"

namespace octant {
namespace epoch_fix_test {

using test::hall;
using test::hear;
using test::Hearing;
using test::position_error_m;
using test::random_pose;
using test::with_octagon;
using test::with_receiver;

constexpr std::uint64_t kSeed = 20260;

double heading_error_rad(const Pose& a, const Pose& b) {
  return std::abs(wrap_angle(a.heading_rad() - b.heading_rad()));
}

TEST(EpochFix, IsExactWithoutNoise) {
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  const Deployment d = with_octagon(hall());
  LeastSquaresLocalizer localizer(d);
  for (int k = 0; k < 50; ++k) {
    const Pose truth = random_pose(random);
    const Fix fix = localizer.locate(hear(d, truth, {}, random));
    ASSERT_TRUE(fix.ok()) << k << " " << to_string(fix.status);
    // Gauss-Newton converges quadratically without residuals: only rounding remains.
    EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-9) << k;
    EXPECT_LT(heading_error_rad(fix.T_map_vehicle, truth), 1e-8) << k;
    EXPECT_EQ(fix.arrivals_rejected, 0);
  }
}

TEST(EpochFix, IsExactWithTimeWalkAndTemperature) {
  std::mt19937_64 random(kSeed);
  Deployment d = with_octagon(hall());
  d.attenuation = AttenuationModel{12.5, 0.12, 0.05, 4.5e-4};
  LeastSquaresLocalizer localizer(d);
  for (int k = 0; k < 20; ++k) {
    const Pose truth = random_pose(random);
    const Fix fix = localizer.locate(hear(d, truth, {}, random));
    ASSERT_TRUE(fix.ok()) << k << " " << to_string(fix.status);
    EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-9) << k;
  }
}

TEST(EpochFix, FindsTheCycleOffset) {
  std::mt19937_64 random(kSeed);
  Deployment d = with_octagon(hall());
  d.timing.clock = Clock::kCycleOffset;
  LeastSquaresLocalizer localizer(d);
  for (int k = 0; k < 30; ++k) {
    const Pose truth = random_pose(random);
    const Fix fix =
        localizer.locate(hear(d, truth, {.range_m = 15.0, .cycle_offset_s = 0.037 - 0.003 * k}, random));
    ASSERT_TRUE(fix.ok()) << k << " " << to_string(fix.status);
    EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-9) << k;
  }
}

/// Errors against their covariance: the sum of NEES over all fixes is chi-square with three degrees of
/// freedom each.
TEST(EpochFix, CovarianceIsConsistent) {
  std::cout << "seed " << kSeed + 1 << "\n";
  std::mt19937_64 random(kSeed + 1);
  const Deployment d = with_octagon(hall());
  LeastSquaresLocalizer localizer(d);
  double nees = 0.0;
  int count = 0;
  for (int k = 0; k < 500; ++k) {
    const Pose truth = random_pose(random);
    const Fix fix = localizer.locate(hear(d, truth, {.noise_s = 1e-5}, random));
    if (!fix.ok()) continue;
    Eigen::Vector3d e = fix.T_map_vehicle.translation_m - truth.translation_m;
    e[2] = wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad());
    nees += e.dot(fix.covariance.inverse() * e);
    ++count;
  }
  EXPECT_GE(count, 495);
  // 1e-4 on either side; the gate at 4 sigma and the curvature of the heading take less than 3 % more.
  EXPECT_LT(nees, 1.03 * test::chi2_quantile(1 - 1e-4, 3.0 * count));
  EXPECT_GT(nees, test::chi2_quantile(1e-4, 3.0 * count) / 1.03);
}

TEST(EpochFix, RejectsEchoesAndKeepsTheRest) {
  std::cout << "seed " << kSeed + 2 << "\n";
  std::mt19937_64 random(kSeed + 2);
  const Deployment d = with_octagon(hall());
  LeastSquaresLocalizer localizer(d);
  std::uniform_real_distribution<double> uniform(0, 1);
  int judged = 0, missed = 0;
  for (int k = 0; k < 200; ++k) {
    const Pose truth = random_pose(random);
    std::vector<Arrival> arrivals = hear(d, truth, {.noise_s = 1e-5}, random);
    std::vector<bool> shadowed(d.beacons.size());
    std::vector<double> detour_s(d.beacons.size());
    for (std::size_t b = 0; b < d.beacons.size(); ++b) {
      shadowed[b] = uniform(random) < 0.15;
      detour_s[b] = 1e-3 * std::exp(uniform(random) * std::log(10.0));
    }
    std::vector<bool> late(arrivals.size());
    std::vector<int> good(d.beacons.size());
    int clear = 0;
    for (std::size_t i = 0; i < arrivals.size(); ++i) {
      const std::size_t b = arrivals[i].beacon.index();
      const bool alone = uniform(random) < 0.15;
      late[i] = shadowed[b] || alone;
      if (late[i])
        arrivals[i].tof_s += shadowed[b] ? detour_s[b] : 1e-3 * std::exp(uniform(random) * std::log(10.0));
      good[b] += late[i] ? 0 : 1;
      clear += late[i] ? 0 : 1;
    }
    // Case that the truth decides: three beacons with two direct arrivals each, seven in all.
    if (std::count_if(good.begin(), good.end(), [](int n) { return n > 1; }) < 3 || clear < 7) continue;
    const Fix fix = localizer.locate(arrivals);
    ++judged;
    if (!fix.ok()) {
      ++missed;
      continue;
    }
    // Five sigma of the covariance: 6e-7 by chance.
    EXPECT_LT(position_error_m(fix.T_map_vehicle, truth),
              5 * std::sqrt(fix.covariance.topLeftCorner<2, 2>().trace()))
        << k;
    for (std::size_t i = 0; i < arrivals.size(); ++i)
      EXPECT_TRUE(!late[i] || fix.rejections[i] == Rejection::kLate) << k << " " << i;
  }
  EXPECT_GT(judged, 120);
  EXPECT_LE(missed, judged / 20);
}

TEST(EpochFix, AllEchoesIsNoFix) {
  std::mt19937_64 random(kSeed + 3);
  const Deployment d = with_octagon(hall());
  LeastSquaresLocalizer localizer(d);
  std::uniform_real_distribution<double> detour(1e-3, 12e-3);
  int fixes = 0;
  for (int k = 0; k < 50; ++k) {
    std::vector<Arrival> arrivals = hear(d, random_pose(random), {.noise_s = 1e-5}, random);
    for (Arrival& a : arrivals) a.tof_s += detour(random);
    const Fix fix = localizer.locate(arrivals);
    fixes += fix.ok();
    EXPECT_TRUE(fix.T_map_vehicle.translation_m.allFinite());
  }
  EXPECT_EQ(fixes, 0);
}

TEST(EpochFix, TwoBeaconsAndOneReceiverAreAmbiguous) {
  std::mt19937_64 random(kSeed + 4);
  Deployment d = with_receiver(hall(), {0, 0, 0.3});
  d.beacons.resize(2);
  LeastSquaresLocalizer localizer(d);
  const Fix fix = localizer.locate(hear(d, Pose::planar(6, 5, 0.4), {.range_m = 50}, random));
  EXPECT_EQ(fix.status, FixStatus::kAmbiguous) << to_string(fix.status);
}

TEST(EpochFix, ArrayTellsTheMirrorImageOfTwoBeacons) {
  std::mt19937_64 random(kSeed + 5);
  Deployment d = with_octagon(hall());
  d.beacons.resize(2);
  LeastSquaresLocalizer localizer(d);
  for (int k = 0; k < 20; ++k) {
    const Pose truth = random_pose(random);
    const Fix fix = localizer.locate(hear(d, truth, {.range_m = 50}, random));
    EXPECT_TRUE(!fix.ok() || position_error_m(fix.T_map_vehicle, truth) < 1e-6) << k;
    EXPECT_TRUE(fix.ok() || fix.status == FixStatus::kAmbiguous || fix.status == FixStatus::kPoorGeometry)
        << k << to_string(fix.status);
  }
}

TEST(EpochFix, CollinearBeaconsAndOneReceiverAreAmbiguous) {
  std::mt19937_64 random(kSeed + 6);
  Deployment d = with_receiver(hall(), {0, 0, 0.3});
  d.beacons.resize(5);
  for (std::size_t i = 0; i < d.beacons.size(); ++i)
    d.beacons[i].position_m = {2.0 + 4.0 * static_cast<double>(i), 0.0, 2.5};
  LeastSquaresLocalizer localizer(d);
  const Fix fix = localizer.locate(hear(d, Pose::planar(8, 4, 0.0), {.range_m = 50}, random));
  EXPECT_EQ(fix.status, FixStatus::kAmbiguous) << to_string(fix.status);
}

TEST(EpochFix, SingleReceiverOnTheAxisStillGivesThePosition) {
  std::mt19937_64 random(kSeed + 7);
  const Deployment d = with_receiver(hall(), {0, 0, 0.3});
  LeastSquaresLocalizer localizer(d);
  const Pose truth = Pose::planar(7, 5, 1.0);
  const Fix fix = localizer.locate(hear(d, truth, {.range_m = 50}, random));
  ASSERT_TRUE(fix.ok()) << to_string(fix.status);
  EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-9);
  EXPECT_NEAR(std::sqrt(fix.covariance(2, 2)), std::numbers::pi, 0.01);  // no knowledge at all
}

TEST(EpochFix, TooFewArrivals) {
  std::mt19937_64 random(kSeed + 8);
  const Deployment d = with_octagon(hall());
  LeastSquaresLocalizer localizer(d);
  std::vector<Arrival> arrivals = hear(d, Pose::planar(6, 5, 0.4), {}, random);
  EXPECT_EQ(localizer.locate(std::span<const Arrival>{}).status, FixStatus::kTooFewArrivals);
  EXPECT_EQ(localizer.locate(std::span(arrivals).first(1)).status, FixStatus::kTooFewArrivals);
  // All of one beacon: its circle.
  std::vector<Arrival> one;
  for (const Arrival& a : arrivals)
    if (a.beacon == arrivals.front().beacon) one.push_back(a);
  EXPECT_FALSE(localizer.locate(one).ok());
}

TEST(EpochFix, LeavesOutUndeterminedBeacons) {
  std::mt19937_64 random(kSeed + 9);
  Deployment d = with_octagon(hall());
  const Pose truth = Pose::planar(9, 6, -2.0);
  const std::vector<Arrival> arrivals = hear(d, truth, {}, random);
  d.beacons[arrivals.front().beacon.index()].status = BeaconStatus::kUndetermined;
  d.beacons[arrivals.front().beacon.index()].position_m += Eigen::Vector3d(3, -2, 0);
  const Fix fix = LeastSquaresLocalizer(d).locate(arrivals);
  ASSERT_TRUE(fix.ok()) << to_string(fix.status);
  EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-9);
  EXPECT_EQ(fix.rejections.front(), Rejection::kBeaconUnusable);
}

/// Beacons known to 0.3 m: the fix cannot be better than they are, but the heading follows from the
/// differences.
TEST(EpochFix, SlackKeepsTheHeading) {
  std::cout << "seed " << kSeed + 10 << "\n";
  std::mt19937_64 random(kSeed + 10);
  std::normal_distribution<double> normal;
  const Deployment truth_deployment = with_octagon(hall());
  double worst_m = 0.0, worst_rad = 0.0;
  int fixes = 0;
  for (int k = 0; k < 60; ++k) {
    Deployment d = truth_deployment;
    for (DeploymentBeacon& b : d.beacons)
      for (int i = 0; i < 3; ++i) b.position_m[i] += 0.3 * normal(random);
    EpochFixOptions options;
    options.range_uncertainty_m = 0.3;
    const Pose truth = random_pose(random);
    const Fix fix =
        LeastSquaresLocalizer(d, options).locate(hear(truth_deployment, truth, {.noise_s = 1e-5}, random));
    if (!fix.ok()) continue;
    ++fixes;
    worst_m = std::max(worst_m, position_error_m(fix.T_map_vehicle, truth));
    worst_rad = std::max(worst_rad, heading_error_rad(fix.T_map_vehicle, truth));
  }
  EXPECT_GE(fixes, 55);
  EXPECT_LT(worst_m, 1.5);     // 0.3 m with a dilution of precision up to 1.3, four sigma
  EXPECT_LT(worst_rad, 0.35);  // five beacons give 0.03 rad by noise, their wrong directions 0.05 more
}

TEST(EpochFix, MeasuredPoseServesAsStart) {
  std::mt19937_64 random(kSeed + 11);
  const Deployment d = with_octagon(hall());
  const Pose truth = Pose::planar(5, 4, 2.5);
  MeasurementLog log;
  log.has_epochs = true;
  log.vehicle = VehicleId(0);
  log.arrivals = hear(d, truth, {}, random);
  log.poses = {{-1.0, truth}, {10.0, truth}};
  log.pose_accuracy = {.position_sigma_m = 0.01,
                       .heading_sigma_rad = 0.0,
                       .heading_known = false,
                       .attitude_sigma_rad = 0.01,
                       .max_gap_s = 100};
  const std::vector<Fix> fixes = LeastSquaresLocalizer(d).locate(log);
  ASSERT_EQ(fixes.size(), 1u);
  ASSERT_TRUE(fixes[0].ok()) << to_string(fixes[0].status);
  EXPECT_LT(heading_error_rad(fixes[0].T_map_vehicle, truth), 1e-7);
}

TEST(EpochFix, SpatialMotion) {
  std::mt19937_64 random(kSeed + 12);
  Deployment d = hall();
  d.motion = Motion::kSpatial;
  for (std::size_t i = 0; i < d.beacons.size(); ++i) d.beacons[i].position_m.z() = i % 2 == 0 ? 0.5 : 3.5;
  d = with_receiver(
      with_receiver(with_receiver(with_receiver(d, {0.5, 0, 0}), {-0.4, 0.4, 0}), {-0.4, -0.4, 0.1}),
      {0, 0, 0.5});
  LeastSquaresLocalizer localizer(d);
  Pose truth;
  truth.translation_m = {7, 5, 1.4};
  truth.rotation = exp_rotation({0.3, -0.2, 1.9});
  const Fix fix = localizer.locate(hear(d, truth, {.range_m = 50}, random));
  ASSERT_TRUE(fix.ok()) << to_string(fix.status);
  EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-8);
  EXPECT_LT(fix.T_map_vehicle.rotation.angularDistance(truth.rotation), 1e-7);
  EXPECT_EQ(fix.covariance.rows(), 6);
}

/// Moving the world moves the answer with it.
RC_GTEST_PROP(EpochFixProperty, FollowsARigidMotionOfTheWorld, ()) {
  const auto number = [](int range) { return *rc::gen::inRange(-range, range); };
  const Pose M = Pose::planar(0.1 * number(1000), 0.1 * number(1000), 0.001 * number(3141));
  std::mt19937_64 random(static_cast<std::uint64_t>(*rc::gen::inRange(0, 1000000)));
  const Deployment d = with_octagon(hall());
  const std::vector<Arrival> arrivals = hear(d, random_pose(random), {.noise_s = 1e-5}, random);
  Deployment moved = d;
  for (DeploymentBeacon& b : moved.beacons) b.position_m = M * b.position_m;
  const Fix here = LeastSquaresLocalizer(d).locate(arrivals),
            there = LeastSquaresLocalizer(moved).locate(arrivals);
  RC_ASSERT(here.status == there.status);
  if (!here.ok()) return;
  const Pose expected = M * here.T_map_vehicle;
  // The adjustment stops when half the gain is below 1e-10: within 1e-5 sigma, some 1e-7 m, of the optimum.
  RC_ASSERT(position_error_m(expected, there.T_map_vehicle) < 1e-6);
  RC_ASSERT(heading_error_rad(expected, there.T_map_vehicle) < 1e-5);
  RC_ASSERT(here.rejections == there.rejections);
}

RC_GTEST_PROP(EpochFixProperty, DoesNotDependOnTheOrderOfRows, ()) {
  std::mt19937_64 random(static_cast<std::uint64_t>(*rc::gen::inRange(0, 1000000)));
  const Deployment d = with_octagon(hall());
  std::vector<Arrival> arrivals = hear(d, random_pose(random), {.noise_s = 1e-5}, random);
  for (Arrival& a : arrivals) a.time_s = 0.0;  // else the order would be wrong
  std::uniform_int_distribution<std::size_t> any(0, arrivals.size() - 1);
  arrivals[any(random)].tof_s += 2e-3;
  LeastSquaresLocalizer localizer(d);
  const Fix first = localizer.locate(arrivals);
  std::shuffle(arrivals.begin(), arrivals.end(), random);
  const Fix second = localizer.locate(arrivals);
  RC_ASSERT(first.status == second.status);
  if (!first.ok()) return;
  RC_ASSERT(position_error_m(first.T_map_vehicle, second.T_map_vehicle) < 1e-6);  // as above
  RC_ASSERT(first.arrivals_used == second.arrivals_used);
}

}  // namespace epoch_fix_test
}  // namespace octant
