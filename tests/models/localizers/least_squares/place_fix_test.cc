// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/place_fix.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/localizers/common/open_attitude.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/simulator/random.h"

namespace octant {
namespace place_fix_test {

constexpr double kSpeed_mps = 340.0, kSigma_m = 0.03;

const std::vector<Eigen::Vector3d> kHall = {{0, 0, 0.3}, {10, 0, 4.0}, {10, 8, 0.5},
                                            {0, 8, 4.2}, {5, -1, 3.0}, {5, 9, 1.0}};

/// A vehicle in space with receivers at these places.
Deployment in_space(const std::vector<Eigen::Vector3d>& beacons,
                    const std::vector<Eigen::Vector3d>& receivers, Clock clock = Clock::kSynchronised) {
  Deployment d;
  d.motion = Motion::kSpatial;
  d.medium.model = MediumModel::kConstant;
  d.medium.speed_mps = kSpeed_mps;
  d.timing.clock = clock;
  d.noise.tof_sigma_s = kSigma_m / kSpeed_mps;
  for (const Eigen::Vector3d& p : beacons) {
    DeploymentBeacon& b = d.beacons.emplace_back();
    b.name = "B" + std::to_string(d.beacons.size());
    b.position_m = p;
  }
  SiteVehicle& vehicle = d.vehicles.emplace_back();
  vehicle.receiver_count = receivers.size();
  for (const Eigen::Vector3d& p : receivers) {
    DeploymentReceiver& receiver = d.receivers.emplace_back();
    receiver.vehicle = VehicleId(0);
    receiver.position_m = p;
  }
  return d;
}

/// One arrival over each path.
std::vector<Arrival> heard_at(const Deployment& d, const Pose& T, Random& random, double offset_s = 0.0) {
  std::vector<Arrival> arrivals;
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    for (std::size_t r = 0; r < d.receivers.size(); ++r) {
      Arrival& a = arrivals.emplace_back();
      a.beacon = BeaconId(b);
      a.receiver = ReceiverId(r);
      a.vehicle = VehicleId(0);
      a.epoch = 1;
      a.tof_s =
          ((T * d.receivers[r].position_m - d.beacons[b].position_m).norm() + kSigma_m * random.normal()) /
              kSpeed_mps +
          offset_s;
    }
  return arrivals;
}

Pose somewhere(Random& random) {
  const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
  return {{random.uniform(2, 8), random.uniform(1, 7), random.uniform(0.5, 3.5)},
          Eigen::Quaterniond(Eigen::AngleAxisd(random.uniform(0, 3), axis.normalized()))};
}

/// Mean squared error over its covariance and degrees of freedom, of `count` fixes; all must be fixes.
double nees_of(const Deployment& d, int count, double offset_s) {
  LeastSquaresLocalizer localizer(d);
  Random random(1, 1);
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const Pose truth = somewhere(random);
    const Fix fix = localizer.locate(heard_at(d, truth, random, offset_s));
    EXPECT_TRUE(fix.ok()) << to_string(fix.status);
    EXPECT_TRUE(has_open_attitude(fix));
    const Eigen::Vector3d off = fix.T_map_vehicle.translation_m - truth.translation_m;
    sum += off.dot(Eigen::Matrix3d(fix.covariance.topLeftCorner<3, 3>()).ldlt().solve(off)) / 3;
  }
  return sum / count;
}

// Chi-square of 900 degrees of freedom stays within these limits but once in a thousand times.
TEST(PlaceFix, OfOneAntennaIsAsGoodAsItSays) {
  const double nees = nees_of(in_space(kHall, {Eigen::Vector3d::Zero()}), 300, 0.0);
  EXPECT_GT(nees, 0.85);
  EXPECT_LT(nees, 1.16);
}

TEST(PlaceFix, FindsTheOffsetOfACycleToo) {
  const double nees = nees_of(in_space(kHall, {Eigen::Vector3d::Zero()}, Clock::kCycleOffset), 300, 0.02);
  EXPECT_GT(nees, 0.85);
  EXPECT_LT(nees, 1.16);
}

TEST(PlaceFix, LeavesAnEchoOut) {
  const Deployment d = in_space(kHall, {Eigen::Vector3d::Zero()});
  LeastSquaresLocalizer localizer(d);
  Random random(2, 1);
  for (std::size_t late = 0; late < kHall.size(); ++late) {
    const Pose truth = somewhere(random);
    std::vector<Arrival> arrivals = heard_at(d, truth, random);
    arrivals[late].tof_s += 2.0 / kSpeed_mps;
    const Fix fix = localizer.locate(arrivals);
    ASSERT_TRUE(fix.ok()) << to_string(fix.status);
    EXPECT_EQ(fix.rejections[late], Rejection::kLate);
    EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), 10 * kSigma_m);
  }
}

TEST(PlaceFix, OfBeaconsInAPlaneIsAmbiguous) {
  std::vector<Eigen::Vector3d> ceiling = kHall;
  for (Eigen::Vector3d& p : ceiling) p.z() = 4.0;
  const Deployment d = in_space(ceiling, {Eigen::Vector3d::Zero()});
  Random random(3, 1);
  EXPECT_EQ(LeastSquaresLocalizer(d).locate(heard_at(d, Pose{{4, 3, 1}, {}}, random)).status,
            FixStatus::kAmbiguous);
}

TEST(PlaceFix, OfBeaconsInALineHasPoorGeometry) {
  const Deployment d =
      in_space({{0, 0, 1}, {2, 0, 1.5}, {4, 0, 2}, {6, 0, 2.5}, {8, 0, 3}}, {Eigen::Vector3d::Zero()});
  Random random(4, 1);
  EXPECT_EQ(LeastSquaresLocalizer(d).locate(heard_at(d, Pose{{4, 3, 1}, {}}, random)).status,
            FixStatus::kPoorGeometry);
}

TEST(PlaceFix, TwoBeaconsAreTooFew) {
  const Deployment d = in_space({kHall[0], kHall[1]}, {Eigen::Vector3d::Zero()});
  Random random(5, 1);
  EXPECT_EQ(LeastSquaresLocalizer(d).locate(heard_at(d, Pose{{4, 3, 1}, {}}, random)).status,
            FixStatus::kTooFewArrivals);
}

// With one antenna the place is the antenna's; the origin is on a sphere about it.
TEST(PlaceFix, CountsTheLeverArm) {
  const Eigen::Vector3d lever_m(3, -1, 2);
  const Deployment d = in_space(kHall, {lever_m});
  LeastSquaresLocalizer localizer(d);
  Random random(6, 1);
  const Pose truth = somewhere(random);
  const Fix fix = localizer.locate(heard_at(d, truth, random));
  ASSERT_TRUE(fix.ok());
  EXPECT_LT((fix.T_map_vehicle.translation_m - truth * lever_m).norm(), 6 * kSigma_m);
  EXPECT_GT(fix.covariance(0, 0), open_attitude_variance_m2(lever_m));
  EXPECT_GT(fix.protection_level_m, lever_m.norm());
}

TEST(PlaceFix, ThreeReceiversOffOneLineGiveAPose) {
  const Deployment d = in_space(kHall, {{0.3, 0, 0}, {-0.2, 0.3, 0}, {-0.2, -0.3, 0.1}});
  LeastSquaresLocalizer localizer(d);
  Random random(7, 1);
  EXPECT_FALSE(has_open_attitude(localizer.locate(heard_at(d, somewhere(random), random))));
}

}  // namespace place_fix_test
}  // namespace octant
