// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/space_ranges.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/common/open_attitude.h"
#include "models/simulator/random.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {
namespace space_ranges_test {

Deployment beacons_at(const std::vector<Eigen::Vector3d>& places) {
  Deployment d;
  d.motion = Motion::kSpatial;
  d.medium.speed_mps = 343.7;
  d.noise.tof_sigma_s = 1e-5;
  for (const Eigen::Vector3d& p : places) {
    DeploymentBeacon b;
    b.name = "B" + std::to_string(d.beacons.size());
    b.position_m = p;
    b.delay_s = 1e-4;
    d.beacons.push_back(b);
  }
  d.vehicles.push_back({"robot", 0, 0});
  return with_receiver(d, {0, 0, 0});
}

std::vector<Eigen::Vector3d> scattered(int count, Random& draws, double height_m) {
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < count; ++i)
    places.emplace_back(draws.uniform(0, 20), draws.uniform(0, 12), 3 + height_m * draws.uniform(-1, 1));
  return places;
}

RC_GTEST_PROP(BeaconPlane, OfBeaconsInAPlaneIsThatPlane, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  std::vector<Eigen::Vector3d> places = scattered(*rc::gen::inRange(4, 10), draws, 0.0);
  const Pose tipped{draws.normal3(), exp_rotation(draws.normal3())};
  const Eigen::Vector3d normal = tipped.rotation * Eigen::Vector3d::UnitZ();
  for (Eigen::Vector3d& p : places) p = tipped * p;
  const BeaconPlane plane = beacon_plane(beacons_at(places), 20.0);
  RC_ASSERT(plane.coplanar);
  RC_ASSERT(std::abs(std::abs(plane.normal.dot(normal)) - 1) < 1e-9);
  RC_ASSERT(plane.off_m < 1e-6);
  for (const Eigen::Vector3d& p : places) RC_ASSERT(std::abs(plane.height_m(p)) < 1e-9);
  RC_ASSERT(std::abs(plane.height_m(places[0] + 2.0 * plane.normal) - 2.0) < 1e-9);
}

RC_GTEST_PROP(BeaconPlane, IsTheOneOfLeastSquares, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const std::vector<Eigen::Vector3d> places = scattered(7, draws, 2.0);
  const BeaconPlane plane = beacon_plane(beacons_at(places), 20.0);
  const auto squares = [&](const Eigen::Vector3d& centre, const Eigen::Vector3d& normal) {
    double sum = 0.0;
    for (const Eigen::Vector3d& p : places) sum += std::pow(normal.normalized().dot(p - centre), 2);
    return sum;
  };
  const double least = squares(plane.centre_m, plane.normal);
  RC_ASSERT(std::abs(std::sqrt(least / 7) - plane.off_m) < 1e-9);
  for (int i = 0; i < 20; ++i)
    RC_ASSERT(squares(plane.centre_m + 0.1 * draws.normal3(), plane.normal + 0.1 * draws.normal3()) >=
              least * (1 - 1e-9));
}

TEST(BeaconPlane, ThreeBeaconsAlwaysLieInOneAndATwentiethOffItIsNone) {
  EXPECT_TRUE(beacon_plane(beacons_at({{0, 0, 1}, {5, 0, 4}, {0, 5, 2}}), 7.0).coplanar);
  const std::vector<Eigen::Vector3d> square = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {10, 10, 0}};
  for (const double off_m : {0.6, 2.0}) {
    std::vector<Eigen::Vector3d> places = square;
    places[0].z() = places[3].z() = off_m;
    places[1].z() = places[2].z() = -off_m;
    EXPECT_EQ(beacon_plane(beacons_at(places), std::sqrt(200.0)).coplanar, off_m < 1.0) << off_m;
  }
}

TEST(BeaconPlane, LeavesOutTheOneThatIsDoubtedAndThoseThatAreNotDetermined) {
  Deployment d = beacons_at({{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {10, 10, 0}, {5, 5, 8}});
  EXPECT_FALSE(beacon_plane(d, 16.0).coplanar);
  EXPECT_TRUE(beacon_plane(d, 16.0, BeaconId(4)).coplanar);
  d.beacons[4].status = BeaconStatus::kUndetermined;
  EXPECT_TRUE(beacon_plane(d, 16.0).coplanar);
  EXPECT_EQ(beacon_plane(Deployment(), 1.0).centre_m, Eigen::Vector3d(0, 0, 0));
}

TEST(SpaceSetting, ABeaconsDistanceFromThePlaneIsKnownAsItsHeightIs) {
  Deployment d = beacons_at({{0, 0, 3}, {10, 0, 3}, {0, 10, 3}, {10, 10, 3}});
  for (std::size_t b = 0; b < 4; ++b)
    for (std::size_t i = 0; i < 3; ++i) d.covariance.parameters.push_back(parameters::beacon_position(b, i));
  Eigen::VectorXd variance(12);
  for (Eigen::Index i = 0; i < 12; ++i) variance[i] = 1e-4 * static_cast<double>(i + 1);
  d.covariance.matrix = variance.asDiagonal();
  const SpaceTrackOptions options;
  const SpaceSetting setting(d, options);
  for (std::size_t b = 0; b < 4; ++b)
    EXPECT_NEAR(setting.off_plane_m2[b], 1e-4 * static_cast<double>(3 * b + 3), 1e-15) << "its z alone";
  EXPECT_NEAR(setting.extent_m, std::sqrt(200.0), 1e-12);
  EXPECT_EQ(setting.size, 6) << "no errors that last, no states for them";
}

TEST(SpaceSetting, ErrorsThatLastHaveAStateForEachUsableBeacon) {
  Deployment d = beacons_at({{0, 0, 3}, {10, 0, 3}, {0, 10, 3}, {10, 10, 3}});
  d.correlated_noise = {.sigma_s = 3e-6, .time_s = 20.0, .pair_sigma_s = 4e-6};
  d.beacons[1].status = BeaconStatus::kUndetermined;
  const SpaceTrackOptions options;
  const SpaceSetting setting(d, options);
  EXPECT_EQ(setting.size, 9);
  EXPECT_EQ(setting.bias, (std::vector<int>{6, -1, 7, 8}));
  EXPECT_NEAR(setting.bias_sigma_m, 343.7 * 5e-6, 1e-12);  // 3, 4, 5
  EXPECT_GT(setting.bias_time_s, 20.0) << "a part of them lasts for good";
}

/// Pings of all beacons from a place, one every tenth of a second.
MeasurementLog pings(const Deployment& d, const Eigen::Vector3d& p, int count) {
  MeasurementLog log;
  log.vehicle = VehicleId(0);
  std::mt19937_64 random(3);
  for (int i = 0; i < count; ++i)
    for (Arrival a : hear(d, Pose{p, Eigen::Quaterniond::Identity()}, {.range_m = 100}, random)) {
      a.time_s = 0.1 * i + 1e-4 * static_cast<double>(a.beacon.index());
      a.epoch = kNoEpoch;
      log.arrivals.push_back(a);
    }
  return log;
}

TEST(RangesInSpace, AreDistancesAndArrivalsOfOnePingOneInstant) {
  Deployment d = beacons_at({{0, 0, 0}, {10, 0, 1}, {0, 10, 2}, {10, 10, 5}, {5, 5, 9}});
  d.beacons[2].status = BeaconStatus::kUndetermined;
  const SpaceTrackOptions options;
  SpaceSetting setting(d, options);
  const Eigen::Vector3d p(4, 3, 2);
  MeasurementLog log = pings(d, p, 7);
  Arrival other = log.arrivals[0];
  other.vehicle = VehicleId(1);
  log.arrivals.insert(log.arrivals.begin(), other);
  const SpaceRanges ranges = ranges_in_space(log, VehicleId(0), setting);
  ASSERT_EQ(ranges.instants.size(), 7U);
  ASSERT_EQ(ranges.all.size(), 35U);
  std::size_t next = 0;
  for (const SpaceInstant& instant : ranges.instants) {
    EXPECT_EQ(instant.first, next);
    EXPECT_EQ(instant.last - instant.first, 5U);
    next = instant.last;
  }
  for (const SpaceRange& r : ranges.all) {
    EXPECT_NEAR(r.distance.range_m, (p - r.p_beacon_m).norm(), 1e-9);
    EXPECT_EQ(r.rejection, r.arrival.beacon == BeaconId(2) ? Rejection::kBeaconUnusable : Rejection::kUsed);
    EXPECT_NEAR(r.variance_m2, std::pow(343.7 * 1e-5, 2), 1e-12);
  }
}

// A receiver off the receivers' centre is somewhere on a sphere about it: a third of its square in each axis.
TEST(RangesInSpace, CountWhatTheAttitudeMayPutAReceiverOff) {
  Deployment d = with_receiver(beacons_at({{0, 0, 0}, {10, 0, 1}, {0, 10, 2}, {10, 10, 5}}), {0.6, 0, 0});
  const SpaceTrackOptions options;
  SpaceSetting setting(d, options);
  const SpaceRanges ranges = ranges_in_space(pings(d, {4, 3, 2}, 1), VehicleId(0), setting);
  EXPECT_NEAR(open_attitude_variance_m2(setting.p_centre_vehicle_m), 0.09 / 3, 1e-15);
  for (const SpaceRange& r : ranges.all)
    EXPECT_NEAR(r.variance_m2 - std::pow(343.7 * 1e-5, 2), 0.09 / 3, 1e-12);
}

TEST(PlaceInSpace, IsWhereAllRangesMeet) {
  const Deployment d = beacons_at({{0, 0, 0}, {10, 0, 1}, {0, 10, 2}, {10, 10, 5}, {5, 5, 9}});
  const SpaceTrackOptions options;
  SpaceSetting setting(d, options);
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(4, 3, 2), Eigen::Vector3d(9, 9, 0.5), Eigen::Vector3d(1, 2, 7)}) {
    const SpaceRanges ranges = ranges_in_space(pings(d, p, 3), VehicleId(0), setting);
    const auto found = place_in_space(ranges, 0, setting);
    ASSERT_TRUE(found.has_value());
    EXPECT_LT((found->p_map_m - p).norm(), 0.01);  // it ends at a millionth of the extent, some steps before
  }
}

TEST(PlaceInSpace, OfBeaconsInAPlaneIsAboveTheFloorAndBelowThem) {
  const Deployment d = beacons_at({{0, 0, 4}, {10, 0, 4}, {0, 10, 4}, {10, 10, 4}});
  const SpaceTrackOptions options;
  SpaceSetting setting(d, options);
  const auto below = ranges_in_space(pings(d, {4, 3, 1}, 3), VehicleId(0), setting);
  EXPECT_LT((place_in_space(below, 0, setting)->p_map_m - Eigen::Vector3d(4, 3, 1)).norm(), 0.01)
      << "not at 7 m";
  const auto high = ranges_in_space(pings(d, {4, 3, 9}, 3), VehicleId(0), setting);
  EXPECT_LT((place_in_space(high, 0, setting)->p_map_m - Eigen::Vector3d(4, 3, 9)).norm(), 0.01)
      << "not under the floor";
}

TEST(PlaceInSpace, OfTwoBeaconsIsNone) {
  const Deployment d = beacons_at({{0, 0, 4}, {10, 0, 3}});
  const SpaceTrackOptions options;
  SpaceSetting setting(d, options);
  EXPECT_FALSE(place_in_space(ranges_in_space(pings(d, {4, 3, 1}, 30), VehicleId(0), setting), 0, setting)
                   .has_value());
}

}  // namespace space_ranges_test
}  // namespace octant::test
