// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/reflectors/reflectors.h"

#include <cmath>
#include <iostream>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/simulator/random.h"
#include "tests/support/allocation_count.h"
#include "tests/support/statistics.h"

namespace octant {
namespace reflectors_test {

constexpr std::uint64_t kSeed = 2015;
constexpr double kSigma = 0.002;  // rad, a laser scanner's

Deployment with_reflectors(const std::vector<Eigen::Vector2d>& p_map_m, double sigma_rad = kSigma) {
  Deployment d;
  d.noise.bearing_sigma_rad = sigma_rad;
  for (const Eigen::Vector2d& p : p_map_m) {
    DeploymentBeacon b;
    b.name = "L" + std::to_string(d.beacons.size());
    b.position_m.head<2>() = p;
    d.beacons.push_back(b);
  }
  d.vehicles.push_back({.name = "agv"});
  return d;
}

/// Nine reflectors round a hall of 35 x 40 m (the size that table 2 implies), in no regular pattern.
Deployment hall() {
  return with_reflectors(
      {{0, 40}, {35, 40}, {35, 0}, {0, 0}, {12.3, 0.2}, {34.8, 17.1}, {21.4, 39.9}, {0.1, 27.6}, {0.2, 8.9}});
}

std::vector<Bearing> see(const Deployment& d, const Pose& T, double sigma_rad, Random& random,
                         double unlabelled = 0.0, double range_m = 1e9, double time_s = 0.0) {
  std::vector<Bearing> out;
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    const Eigen::Vector3d v = T.inverse() * d.beacons[b].position_m;
    if (v.head<2>().norm() > range_m) continue;
    Bearing bearing;
    bearing.time_s = time_s;
    bearing.bearing_rad = wrap_angle(std::atan2(v.y(), v.x()) + sigma_rad * random.normal());
    bearing.vehicle = VehicleId(0);
    bearing.epoch = 0;
    if (random.uniform() >= unlabelled) bearing.reflector = BeaconId(b);
    out.push_back(bearing);
  }
  return out;
}

Pose somewhere(Random& random) {
  return Pose::planar(random.uniform(2, 33), random.uniform(2, 38), random.uniform(-3, 3));
}

Observations of(const std::vector<Bearing>& bearings) { return {{}, bearings}; }

Eigen::Vector3d error(const Fix& fix, const Pose& truth) {
  return {fix.T_map_vehicle.translation_m.x() - truth.translation_m.x(),
          fix.T_map_vehicle.translation_m.y() - truth.translation_m.y(),
          wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad())};
}

TEST(Reflectors, IsExactWithoutNoise) {
  Random random(kSeed);
  for (const double unlabelled : {0.0, 0.5, 1.0}) {
    for (int k = 0; k < 10; ++k) {
      Reflectors localizer(hall());
      const Pose truth = somewhere(random);
      const Fix fix = localizer.locate(of(see(hall(), truth, 0.0, random, unlabelled)));
      ASSERT_TRUE(fix.ok()) << unlabelled << " " << k << " " << to_string(fix.status);
      EXPECT_LT(error(fix, truth).norm(), 1e-8) << k;  // Gauss-Newton stops at 1e-10
      EXPECT_EQ(fix.arrivals_used, 9);
    }
  }
}

/// Two reflectors have labels at wrong bearings, and unlabelled bearings at the right ones: only an
/// assignment that removes a reflector from its labelled bearing leads to the pose.
TEST(Reflectors, TakesBackWhatIsNamedWrongly) {
  Random random(kSeed + 7);
  const Deployment d = with_reflectors({{0, 40}, {35, 38}, {33, 0}, {2, 5}});
  int count = 0;
  for (int k = 0; k < 50; ++k) {
    const Pose truth = somewhere(random);
    auto bearings = see(d, truth, 0.1 * kSigma, random);
    for (const std::size_t b : {2u, 3u}) {
      Bearing wrong = bearings[b];
      wrong.bearing_rad = wrap_angle(wrong.bearing_rad + random.uniform(0.3, 2.0));
      bearings[b].reflector = BeaconId();
      bearings.push_back(wrong);
    }
    Reflectors localizer(d);
    const Fix fix = localizer.locate(of(bearings));
    if (!fix.ok()) continue;
    ++count;
    EXPECT_LT(error(fix, truth).head<2>().norm(), 0.2) << k;
    EXPECT_EQ(fix.arrivals_used, 4);
    EXPECT_EQ(fix.rejections[4], Rejection::kOutvoted);
  }
  EXPECT_GE(count, 45);
}

TEST(Reflectors, CovarianceIsConsistent) {
  std::cout << "seed " << kSeed << "\n";
  Random random(kSeed);
  const Deployment d = hall();
  double nees = 0.0, cost = 0.0;
  constexpr int kFixes = 400;
  int count = 0;
  for (int k = 0; k < kFixes; ++k) {
    Reflectors localizer(d);
    const Pose truth = somewhere(random);
    const Fix fix = localizer.locate(of(see(d, truth, kSigma, random)));
    if (!fix.ok() || fix.arrivals_used < 9) continue;
    const Eigen::Vector3d e = error(fix, truth);
    nees += e.dot(Eigen::Matrix3d(fix.covariance).inverse() * e);
    cost += 2 * fix.cost;
    ++count;
  }
  EXPECT_GE(count, kFixes - 4);  // 6e-5 of 3600 bearings are beyond the gate
  EXPECT_GT(nees, test::chi2_quantile(0.001, 3 * count));
  EXPECT_LT(nees, test::chi2_quantile(0.999, 3 * count));
  EXPECT_GT(cost, test::chi2_quantile(0.001, 6 * count));
  EXPECT_LT(cost, test::chi2_quantile(0.999, 6 * count));
}

TEST(Reflectors, CovarianceHoldsTheReflectorsOwn) {
  Random random(kSeed + 1);
  std::cout << "seed " << kSeed + 1 << "\n";
  Deployment d = hall();
  for (DeploymentBeacon& b : d.beacons) b.covariance_m2 = Eigen::Vector3d(0.01, 0.04, 0.0).asDiagonal();
  double nees = 0.0;
  int count = 0;
  for (int k = 0; k < 400; ++k) {
    Deployment truth_d = d;
    for (DeploymentBeacon& b : truth_d.beacons)
      b.position_m += Eigen::Vector3d(0.1 * random.normal(), 0.2 * random.normal(), 0.0);
    Reflectors localizer(d);
    const Pose truth = Pose::planar(random.uniform(8, 27), random.uniform(8, 32), random.uniform(-3, 3));
    const Fix fix = localizer.locate(of(see(truth_d, truth, kSigma, random)));
    if (!fix.ok()) continue;
    const Eigen::Vector3d e = error(fix, truth);
    nees += e.dot(Eigen::Matrix3d(fix.covariance).inverse() * e);
    ++count;
  }
  EXPECT_GE(count, 396);
  EXPECT_GT(nees, test::chi2_quantile(0.001, 3 * count));
  EXPECT_LT(nees, test::chi2_quantile(0.999, 3 * count));
}

/// Bearings without labels, one in six of an object that is not on the map: never a wrong fix.
TEST(Reflectors, MatchesUnlabelledBearings) {
  Random random(kSeed + 2);
  const Deployment d = hall();
  int fixes = 0;
  constexpr int kEpochs = 40;
  for (int k = 0; k < kEpochs; ++k) {
    Reflectors localizer(d);
    const Pose truth = somewhere(random);
    auto bearings = see(d, truth, kSigma, random, 1.0);
    bearings.erase(bearings.begin() + static_cast<std::ptrdiff_t>(random.uniform() * 8));
    Bearing stray = bearings.front();
    stray.bearing_rad = random.uniform(-3, 3);
    bearings.push_back(stray);
    const Fix fix = localizer.locate(of(bearings));
    if (!fix.ok()) continue;
    ++fixes;
    const Eigen::Vector3d e = error(fix, truth);
    EXPECT_LT(e.dot(Eigen::Matrix3d(fix.covariance).inverse() * e), test::chi2_quantile(1 - 1e-5, 3)) << k;
    EXPECT_GE(fix.arrivals_used, 7);
  }
  EXPECT_GE(fixes, kEpochs * 9 / 10);
}

TEST(Reflectors, SaysThatASquareIsAmbiguousUntilToldWhere) {
  Random random(kSeed);
  const Deployment d = with_reflectors({{0, 0}, {6, 0}, {6, 6}, {0, 6}});
  const Pose truth = Pose::planar(2.0, 3.5, 0.4);
  const auto bearings = see(d, truth, 0.0, random, 1.0);
  Reflectors localizer(d);
  EXPECT_EQ(localizer.locate(of(bearings)).status, FixStatus::kAmbiguous);
  localizer.predict(Pose::planar(2.2, 3.2, 0.3), 0.2, 0.1);
  const Fix fix = localizer.locate(of(bearings));
  ASSERT_TRUE(fix.ok()) << to_string(fix.status);
  EXPECT_LT(error(fix, truth).norm(), 1e-8);
  // From here on the last fix determines the position.
  auto later = see(d, Pose::planar(2.1, 3.5, 0.5), 0.0, random, 1.0, 1e9, 0.2);
  EXPECT_TRUE(localizer.locate(of(later)).ok());
  // Long after, it no longer does.
  later = see(d, Pose::planar(2.1, 3.5, 0.5), 0.0, random, 1.0, 1e9, 1000.0);
  EXPECT_EQ(localizer.locate(of(later)).status, FixStatus::kAmbiguous);
}

TEST(Reflectors, LeavesABearingOutThatDisagrees) {
  Random random(kSeed);
  const Deployment d = hall();
  const Pose truth = somewhere(random);
  auto bearings = see(d, truth, 0.0, random);
  bearings[4].bearing_rad = wrap_angle(bearings[4].bearing_rad + 0.1);
  const Fix fix = Reflectors(d).locate(of(bearings));
  ASSERT_TRUE(fix.ok());
  EXPECT_EQ(fix.rejections[4], Rejection::kOutvoted);
  EXPECT_EQ(fix.arrivals_rejected, 1);
  EXPECT_LT(error(fix, truth).norm(), 1e-8);
  // Any three of four would suffice, so the wrong one cannot be identified.
  bearings.erase(bearings.begin() + 5, bearings.end());
  bearings.erase(bearings.begin());
  EXPECT_EQ(Reflectors(d).locate(of(bearings)).status, FixStatus::kAmbiguous);
}

/// A double of a bearing, within the gate of the same reflector, is no second witness.
TEST(Reflectors, MatchesNoReflectorTwice) {
  Random random(kSeed);
  const Deployment d = hall();
  const Pose truth = somewhere(random);
  auto bearings = see(d, truth, 0.0, random);
  Bearing again = bearings[3];
  again.reflector = BeaconId();
  again.bearing_rad += 0.5 * kSigma;
  bearings.push_back(again);
  const Fix fix = Reflectors(d).locate(of(bearings));
  ASSERT_TRUE(fix.ok());
  EXPECT_EQ(fix.arrivals_used, 9);
  EXPECT_EQ(fix.rejections.back(), Rejection::kOutvoted);
}

TEST(Reflectors, HasNoFixWithAReasonWhereItCannot) {
  Random random(kSeed);
  Deployment d = with_reflectors({{5, 0}, {0, 5}, {-5, 0}});
  EXPECT_EQ(Reflectors(d).locate({}).status, FixStatus::kTooFewArrivals);
  // On the danger circle, and so near to it that the position is good to no metre.
  EXPECT_EQ(Reflectors(d).locate(of(see(d, Pose::planar(0, -5, 1), 0.0, random))).status,
            FixStatus::kPoorGeometry);
  EXPECT_EQ(Reflectors(d).locate(of(see(d, Pose::planar(0, -5.01, 1), 0.0, random))).status,
            FixStatus::kPoorGeometry);
  EXPECT_TRUE(Reflectors(d).locate(of(see(d, Pose::planar(0, -3, 1), 0.0, random))).ok());
  auto bearings = see(d, Pose::planar(0, -3, 1), 0.0, random);
  bearings[0].bearing_rad = std::nan("");
  EXPECT_EQ(Reflectors(d).locate(of(bearings)).status, FixStatus::kTooFewArrivals);
  // Three unlabelled ones agree with any reflectors.
  EXPECT_FALSE(Reflectors(d).locate(of(see(d, Pose::planar(0, -3, 1), 0.0, random, 1.0))).ok());
  d.beacons[1].status = BeaconStatus::kUndetermined;
  const Fix fix = Reflectors(d).locate(of(see(d, Pose::planar(0, -3, 1), 0.0, random)));
  EXPECT_EQ(fix.status, FixStatus::kTooFewArrivals);
  EXPECT_EQ(fix.rejections[1], Rejection::kBeaconUnusable);
  EXPECT_FALSE(reflectors_fits(d));
  EXPECT_TRUE(reflectors_fits(hall()));
}

TEST(Reflectors, AllocatesNothing) {
  Random random(kSeed);
  const Deployment d = hall();
  Reflectors localizer(d, {.max_hypotheses = 3000});
  const auto labelled = see(d, somewhere(random), kSigma, random),
             mixed = see(d, somewhere(random), kSigma, random, 0.5);
  Fix fix;
  localizer.locate(of(labelled), fix);
  const std::size_t before = test::allocations();
  localizer.locate(of(labelled), fix);
  localizer.locate(of(mixed), fix);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace reflectors_test
}  // namespace octant
