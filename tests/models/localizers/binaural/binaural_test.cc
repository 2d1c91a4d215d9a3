// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/binaural/binaural.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "tests/models/localizers/binaural_world.h"
#include "tests/support/allocation_count.h"
#include "tests/support/statistics.h"

namespace octant {
namespace binaural_test {

using test::arrival;
using test::exchange;
using test::kBase_m;
using test::kDegree;
using test::two_robots;

constexpr std::uint64_t kSeed = 1999;

/// Robot 1 in front of robot 2 at (x, y), looking back at it, turned by `turn_rad` off that.
Pose opposite(double x_m, double y_m, double turn_rad) {
  return Pose::planar(x_m, y_m, std::numbers::pi + turn_rad);
}

double off_m(const Fix& fix, const Pose& truth) {
  return (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>().norm();
}
double off_rad(const Fix& fix, const Pose& truth) {
  return std::abs(wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad()));
}

TEST(Circles, MeetInFrontOfTheReceivers) {
  Random random(kSeed);
  for (int k = 0; k < 200; ++k) {
    const double turn = random.uniform(-4, 4);
    const Eigen::Rotation2Dd R(turn);
    const Eigen::Vector2d shift(random.normal(), random.normal());
    const Eigen::Vector2d p1 = R * Eigen::Vector2d(-kBase_m / 2, 0) + shift,
                          p2 = R * Eigen::Vector2d(kBase_m / 2, 0) + shift;
    const Eigen::Vector2d p = R * Eigen::Vector2d(random.uniform(-1, 1), random.uniform(0.2, 6)) + shift;
    const Eigen::Vector2d facing = R * Eigen::Vector2d(0, 1);
    const auto found = intersect_circles(p1, (p - p1).norm(), p2, (p - p2).norm(), facing);
    ASSERT_TRUE(found);
    // Across the line of sight an error of rounding grows by range over baseline, some twenty times.
    EXPECT_LT((*found - p).norm(), 1e-12) << turn;
    // The point behind is the mirror image, which the other facing gives.
    const auto behind = intersect_circles(p1, (p - p1).norm(), p2, (p - p2).norm(), -facing);
    ASSERT_TRUE(behind);
    EXPECT_LT(facing.dot(*behind - p1), 0.0);
  }
}

/// eq. 3-6 divide by y2 - y1: the paper's own receivers, at (-b/2, 0) and (b/2, 0), are where they fail.
TEST(Circles, HaveNoSingularDirection) {
  for (const double angle : {0.0, 90.0, 180.0, 270.0}) {
    const Eigen::Rotation2Dd R(angle * kDegree);
    const auto p =
        intersect_circles(R * Eigen::Vector2d(-0.175, 0), std::hypot(0.475, 1.5),
                          R * Eigen::Vector2d(0.175, 0), std::hypot(0.125, 1.5), R * Eigen::Vector2d(0, 1));
    ASSERT_TRUE(p);
    EXPECT_LT((*p - R * Eigen::Vector2d(0.3, 1.5)).norm(), 1e-14);
  }
}

TEST(Circles, ThatDoNotMeetGiveNothing) {
  const Eigen::Vector2d a(0, 0), b(0.35, 0), ahead(0, 1);
  EXPECT_FALSE(intersect_circles(a, 1.0, b, 1.36, ahead));
  EXPECT_FALSE(intersect_circles(a, 0.1, b, 0.1, ahead));
  EXPECT_FALSE(intersect_circles(a, 1.0, a, 1.0, ahead));
  EXPECT_FALSE(intersect_circles(a, std::nan(""), b, 1.0, ahead));
}

TEST(Height, LengthensRanges) {
  // Section 4.1: 0.25 m at 1.5 m make the range 20.7 mm longer. Without a correction this is the error,
  // within the paper's 4 cm.
  EXPECT_NEAR(std::hypot(1.5, 0.25) - 1.5, 0.0207, 5e-5);
  EXPECT_NEAR(*level_range_m(std::hypot(1.5, 0.25), 0.25), 1.5, 1e-15);
  EXPECT_FALSE(level_range_m(0.2, 0.25));
}

TEST(Binaural, FindsRolesByGeometry) {
  Deployment d = two_robots();
  std::swap(d.beacons[0], d.beacons[2]);      // R2r, R2l, T2
  std::swap(d.receivers[0], d.receivers[1]);  // l, t, r
  const auto roles = binaural_roles(d);
  ASSERT_TRUE(roles) << roles.error().message();
  EXPECT_EQ(d.beacons[roles->transmitter2.index()].name, "T2");
  EXPECT_EQ(d.beacons[roles->left2.index()].name, "R2l");
  EXPECT_EQ(d.beacons[roles->right2.index()].name, "R2r");
  EXPECT_EQ(d.receivers[roles->transmitter1.index()].name, "t");
  EXPECT_EQ(d.receivers[roles->left1.index()].name, "l");
  EXPECT_EQ(d.receivers[roles->right1.index()].name, "r");
}

TEST(Binaural, SaysWhatADeploymentLacks) {
  EXPECT_TRUE(binaural_fits(two_robots()));
  Deployment d = two_robots();
  d.beacons.pop_back();
  EXPECT_NE(binaural_fits(d).error().message().find("2 usable beacons"), std::string::npos);
  d = two_robots();
  d.beacons[1].status = BeaconStatus::kUndetermined;
  EXPECT_FALSE(binaural_fits(d));
  d = two_robots();
  d.receivers[0].position_m = {0.0, kBase_m * 1.5,
                               0.3};  // evenly spaced in a row: left is now between, a role each still
  EXPECT_TRUE(binaural_fits(d));
  d.receivers[0].position_m = {std::sqrt(0.75) * kBase_m, 0.0,
                               0.3};  // equilateral: any may be the transmitter
  EXPECT_FALSE(binaural_fits(d));
  d = two_robots();
  for (DeploymentReceiver& r : d.receivers) std::swap(r.position_m.x(), r.position_m.y());
  EXPECT_FALSE(binaural_fits(d));  // behind each other
  d = two_robots();
  d.timing.clock = Clock::kCycleOffset;
  EXPECT_FALSE(binaural_fits(d));
  EXPECT_EQ(Binaural(d).locate({}).status, FixStatus::kTooFewArrivals);
}

TEST(Binaural, IsExactWithoutNoise) {
  Random random(kSeed);
  Deployment d = two_robots();
  d.beacons[0].position_m = {0.05, 0.02, 0.4};  // the transmitter need not lie between the receivers
  d.receivers[0].position_m = {0.04, -0.03, 0.2};
  d.beacons[0].delay_s = 2e-5;
  d.receivers[1].delay_s = 3e-5;
  Binaural localizer(d);
  for (int k = 0; k < 200; ++k) {
    const double range = random.uniform(0.6, 5.0), sight = random.uniform(-9, 9) * kDegree;
    const Pose truth =
        opposite(range * std::cos(sight), range * std::sin(sight), random.uniform(-9, 9) * kDegree);
    const Fix fix = localizer.locate(Observations{exchange(d, truth, 0.0, random), {}});
    ASSERT_TRUE(fix.ok()) << k << " " << to_string(fix.status);
    EXPECT_LT(off_m(fix, truth), 1e-9)
        << k;  // rounding, twenty times magnified, and the adjustment's stop at 1e-10
    EXPECT_LT(off_rad(fix, truth), 1e-9) << k;
    EXPECT_EQ(fix.arrivals_used, 4);
  }
}

/// eq. 7-9 with the signs of the geometry: seen from itself, each robot finds the other to the same side when
/// they are only offset (section 3); a turn shows on the robot that turns.
TEST(Binaural, SignsFollowGeometry) {
  Random random(kSeed);
  const Deployment d = two_robots();
  Binaural localizer(d);
  for (const double turn : {-9.5, 0.0, 9.5}) {
    const Pose truth = opposite(1.4, 0.1, turn * kDegree);
    const Fix fix = localizer.locate(Observations{exchange(d, truth, 0.0, random), {}});
    ASSERT_TRUE(fix.ok());
    EXPECT_NEAR(wrap_angle(fix.T_map_vehicle.heading_rad() - std::numbers::pi) / kDegree, turn, 1e-6);
    EXPECT_NEAR(fix.T_map_vehicle.translation_m.y(), 0.1, 1e-9);
  }
}

TEST(Binaural, CorrectsKnownHeightAndTilt) {
  Random random(kSeed);
  const Deployment d = two_robots();
  Pose truth = opposite(1.5, 0.1, 5 * kDegree);
  truth.translation_m.z() = 0.25;
  truth.rotation = truth.rotation * Eigen::AngleAxisd(20 * kDegree, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(-8 * kDegree, Eigen::Vector3d::UnitX());
  const auto arrivals = exchange(d, truth, 0.0, random);
  Binaural knows(d, {.height_difference_m = 0.25, .pitch_rad = 20 * kDegree, .roll_rad = -8 * kDegree});
  const Fix corrected = knows.locate(Observations{arrivals, {}});
  ASSERT_TRUE(corrected.ok()) << to_string(corrected.status);
  EXPECT_LT(off_m(corrected, truth), 1e-9);
  // Heading of a tilted vehicle: of its levelled x axis, before pitch and roll.
  EXPECT_NEAR(wrap_angle(corrected.T_map_vehicle.heading_rad() - std::numbers::pi), 5 * kDegree, 1e-9);
  const Fix not_told = Binaural(d).locate(Observations{arrivals, {}});
  EXPECT_TRUE(!not_told.ok() || off_m(not_told, truth) > 0.02);
}

TEST(Binaural, CovarianceIsConsistent) {
  std::cout << "seed " << kSeed << "\n";
  Random random(kSeed);
  const Deployment d = two_robots(1e-6);
  Binaural localizer(d);
  constexpr int kFixes = 500;
  double nees = 0.0, cost = 0.0;
  int count = 0;
  for (int k = 0; k < kFixes; ++k) {
    const Pose truth =
        opposite(random.uniform(0.8, 2.0), random.uniform(-0.1, 0.1), random.uniform(-5, 5) * kDegree);
    const Fix fix = localizer.locate(Observations{exchange(d, truth, 1e-6, random), {}});
    if (!fix.ok()) continue;
    const Eigen::Vector3d e(fix.T_map_vehicle.translation_m.x() - truth.translation_m.x(),
                            fix.T_map_vehicle.translation_m.y() - truth.translation_m.y(),
                            wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad()));
    nees += e.dot(Eigen::Matrix3d(fix.covariance).inverse() * e);
    cost += 2 * fix.cost;
    ++count;
  }
  // The gate at four sigma leaves out 6e-5 of the fixes.
  EXPECT_GE(count, kFixes - 2);
  EXPECT_GT(nees, test::chi2_quantile(0.001, 3 * count));
  EXPECT_LT(nees, test::chi2_quantile(0.999, 3 * count));
  // One redundant range: twice the cost is chi-square with one degree of freedom.
  EXPECT_GT(cost, test::chi2_quantile(0.001, count));
  EXPECT_LT(cost, test::chi2_quantile(0.999, count));
}

/// A new random calibration each time, with the accuracy in the deployment.
TEST(Binaural, CovarianceHoldsTheCalibration) {
  std::cout << "seed " << kSeed + 1 << "\n";
  Random random(kSeed + 1);
  Deployment d = two_robots(2e-7);
  d.speed_sigma_mps = 1.0;
  for (DeploymentBeacon& b : d.beacons) {
    b.covariance_m2 = Eigen::Vector3d(4e-8, 9e-8, 0.0).asDiagonal();
    b.delay_sigma_s = 5e-7;
  }
  for (DeploymentReceiver& r : d.receivers) r.sigma_m = {1e-4, 3e-4, 0.0};
  Binaural localizer(d);
  constexpr int kFixes = 500;
  double nees = 0.0;
  int count = 0;
  for (int k = 0; k < kFixes; ++k) {
    Deployment truth_d = d;
    truth_d.medium.speed_mps += random.normal();
    for (DeploymentBeacon& b : truth_d.beacons) {
      b.position_m += Eigen::Vector3d(2e-4 * random.normal(), 3e-4 * random.normal(), 0.0);
      b.delay_s += 5e-7 * random.normal();
    }
    for (DeploymentReceiver& r : truth_d.receivers) r.position_m += r.sigma_m.cwiseProduct(random.normal3());
    const Pose truth =
        opposite(random.uniform(0.8, 2.0), random.uniform(-0.1, 0.1), random.uniform(-5, 5) * kDegree);
    const Fix fix = localizer.locate(Observations{exchange(truth_d, truth, 2e-7, random), {}});
    if (!fix.ok()) continue;
    const Eigen::Vector3d e(fix.T_map_vehicle.translation_m.x() - truth.translation_m.x(),
                            fix.T_map_vehicle.translation_m.y() - truth.translation_m.y(),
                            wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad()));
    nees += e.dot(Eigen::Matrix3d(fix.covariance).inverse() * e);
    ++count;
  }
  EXPECT_GE(count, kFixes - 2);
  EXPECT_GT(nees, test::chi2_quantile(0.001, 3 * count));
  EXPECT_LT(nees, test::chi2_quantile(0.999, 3 * count));
}

TEST(Binaural, HasNoFixBeyondTheBeam) {
  Random random(kSeed);
  const Deployment d = two_robots();
  Binaural localizer(d);
  const auto status = [&](const Pose& truth) {
    return localizer.locate(Observations{exchange(d, truth, 0.0, random), {}}).status;
  };
  // Figure 6: 0.3 m to the side at 1.5 m, and no more.
  EXPECT_EQ(status(opposite(1.5, 0.299, 0.0)), FixStatus::kOk);
  EXPECT_EQ(status(opposite(1.5, 0.301, 0.0)), FixStatus::kPoorGeometry);
  EXPECT_EQ(status(opposite(1.5, -0.301, 0.0)), FixStatus::kPoorGeometry);
  // Figure 11: a turn of 25 degrees, and no more.
  EXPECT_EQ(status(opposite(1.5, 0.0, 24.9 * kDegree)), FixStatus::kOk);
  EXPECT_EQ(status(opposite(1.5, 0.0, 25.1 * kDegree)), FixStatus::kPoorGeometry);
  EXPECT_EQ(status(opposite(1.5, 0.0, -25.1 * kDegree)), FixStatus::kPoorGeometry);
  Fix fix;
  localizer.locate(Observations{exchange(d, opposite(1.5, 0.5, 0.0), 0.0, random), {}}, fix);
  ASSERT_EQ(fix.rejections.size(), 4u);
  for (const Rejection r : fix.rejections) EXPECT_EQ(r, Rejection::kOutOfRange);
}

TEST(Binaural, HasNoFixWithAReasonWhereItCannot) {
  Random random(kSeed);
  const Deployment d = two_robots();
  Binaural localizer(d);
  const auto good = exchange(d, opposite(1.5, 0.1, 0.0), 0.0, random);
  EXPECT_EQ(localizer.locate({}).status, FixStatus::kTooFewArrivals);
  for (std::size_t missing = 0; missing < 4; ++missing) {
    auto some = good;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(missing));
    EXPECT_EQ(localizer.locate(Observations{some, {}}).status, FixStatus::kTooFewArrivals) << missing;
  }
  auto bad = good;
  bad[0].tof_s = std::nan("");
  EXPECT_EQ(localizer.locate(Observations{bad, {}}).status, FixStatus::kTooFewArrivals);
  bad = good;
  bad[1].tof_s += 2e-3;  // 0.7 m: the circles do not meet
  EXPECT_EQ(localizer.locate(Observations{bad, {}}).status, FixStatus::kPoorGeometry);
  // Any of the four late by 10 mm, half of that in the misclosure, against four sigma of 1.4 mm.
  for (std::size_t late = 0; late < 4; ++late) {
    bad = good;
    bad[late].tof_s += 0.010 / 343.0;
    EXPECT_EQ(localizer.locate(Observations{bad, {}}).status, FixStatus::kNoConsensus) << late;
  }
}

/// Rounds of firings, and the links that a simulator records besides.
TEST(Binaural, AveragesRepeatedArrivalsAndLeavesOthers) {
  Random random(kSeed);
  const Deployment d = two_robots();
  const Pose truth = opposite(1.5, 0.1, 0.0);
  auto arrivals = exchange(d, truth, 1e-6, random);
  const Fix once = Binaural(d).locate(Observations{arrivals, {}});
  const auto again = exchange(d, truth, 1e-6, random);
  arrivals.insert(arrivals.end(), again.begin(), again.end());
  arrivals.push_back(arrival(0, 0, 1.5 / 343));
  arrivals.push_back(arrival(1, 1, 1.5 / 343));
  const Fix twice = Binaural(d).locate(Observations{arrivals, {}});
  ASSERT_TRUE(once.ok() && twice.ok());
  EXPECT_EQ(twice.arrivals_used, 8);
  EXPECT_EQ(twice.arrivals_rejected, 2);
  EXPECT_EQ(twice.rejections.back(), Rejection::kNotNeeded);
  // Variances halve, except for the slightly different position at which they are computed.
  EXPECT_NEAR(twice.covariance(1, 1) / once.covariance(1, 1), 0.5, 0.01);
}

TEST(Binaural, TakesTimeWalkOut) {
  Random random(kSeed);
  Deployment d = two_robots();
  d.attenuation = AttenuationModel{1.0, 0.15, 0.02, 30e-6};
  const Pose truth = opposite(3.0, 0.1, 0.05);
  auto arrivals = exchange(d, truth, 0.0, random);
  for (std::size_t i = 0; i < 4; ++i) {
    const double distance = test::distance_m(d, truth, test::kLinks[i][0], test::kLinks[i][1]);
    const double amplitude = amplitude_v(distance, *d.attenuation);
    arrivals[i].tof_s += *time_walk_s(amplitude, *d.attenuation);
    if (i % 2 == 1) arrivals[i].amplitude_v = amplitude;
  }
  const Fix fix = Binaural(d).locate(Observations{arrivals, {}});
  ASSERT_TRUE(fix.ok());
  EXPECT_LT(off_m(fix, truth), 1e-9);
}

TEST(Binaural, AllocatesNothing) {
  Random random(kSeed);
  const Deployment d = two_robots();
  Binaural localizer(d);
  const auto good = exchange(d, opposite(1.5, 0.1, 0.0), 0.0, random);
  auto late = good;
  late[0].tof_s += 1e-3;
  Fix fix;
  localizer.locate(Observations{good, {}}, fix);
  const std::size_t before = test::allocations();
  for (int k = 0; k < 10; ++k) {
    localizer.locate(Observations{good, {}}, fix);
    localizer.locate(Observations{late, {}}, fix);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace binaural_test
}  // namespace octant
