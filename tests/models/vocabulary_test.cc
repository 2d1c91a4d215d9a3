// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Names, priors and words of the vocabulary: site.h, run.h, fix.h, deployment.h.
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/deployment.h"
#include "models/plain_fix.h"
#include "models/simulator/random.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace vocabulary_test {

/// Two vehicles; the first has two receivers, the second one.
NameTable two_robots() {
  NameTable names;
  names.beacons = {"B0", "B1"};
  names.vehicles = {"left", "right"};
  names.receivers = {{"front", VehicleId(0)}, {"back", VehicleId(0)}, {"front", VehicleId(1)}};
  return names;
}

TEST(NameTable, FindsEachByItsName) {
  const NameTable names = two_robots();
  EXPECT_EQ(names.find_beacon("B1"), BeaconId(1));
  EXPECT_FALSE(names.find_beacon("b1").valid());
  EXPECT_FALSE(names.find_beacon("").valid());
  EXPECT_EQ(names.find_vehicle("right"), VehicleId(1));
  EXPECT_EQ(names.find_receiver(VehicleId(0), "front"), ReceiverId(0));
  EXPECT_EQ(names.find_receiver(VehicleId(1), "front"), ReceiverId(2)) << "of the vehicle that is asked for";
  EXPECT_FALSE(names.find_receiver(VehicleId(1), "back").valid());
}

TEST(NameTable, WhatIsNotNamedIsTheOnlyOneOrTheRobot) {
  NameTable names = two_robots();
  EXPECT_FALSE(names.find_vehicle("").valid());
  names.vehicles[1] = "robot";
  EXPECT_EQ(names.find_vehicle(""), VehicleId(1));
  names.vehicles = {"left"};
  EXPECT_EQ(names.find_vehicle(""), VehicleId(0));
  EXPECT_FALSE(names.find_receiver(VehicleId(0), "").valid()) << "there are two";
  EXPECT_EQ(names.find_receiver(VehicleId(1), ""), ReceiverId(2));
}

TEST(ArrivalOf, ResolvesNames) {
  const auto a = arrival_of(two_robots(), "B1", 0.02, 5.0, "back", "left");
  ASSERT_TRUE(a.has_value());
  EXPECT_EQ(a->beacon, BeaconId(1));
  EXPECT_EQ(a->receiver, ReceiverId(1));
  EXPECT_EQ(a->vehicle, VehicleId(0));
  EXPECT_EQ(a->tof_s, 0.02);
  EXPECT_EQ(a->time_s, 5.0);
  EXPECT_EQ(a->epoch, kNoEpoch);
  EXPECT_TRUE(std::isnan(a->amplitude_v) && std::isnan(a->temperature_degC));
}

TEST(ArrivalOf, SaysWhichNameThereIsNot) {
  const NameTable names = two_robots();
  const auto found = [&](const char* beacon, const char* receiver, const char* vehicle) {
    const auto a = arrival_of(names, beacon, 0.02, 0.0, receiver, vehicle);
    EXPECT_FALSE(a.has_value());
    return a ? std::string() : a.error().found;
  };
  EXPECT_EQ(found("B9", "front", "left"), "beacon 'B9' is not in the deployment");
  EXPECT_EQ(found("B0", "side", "left"), "receiver 'side' is not in the deployment");
  EXPECT_EQ(found("B0", "front", "up"), "vehicle 'up' is not in the deployment");
  EXPECT_EQ(found("B0", "", "left"), "no receiver is named, and there is not just one");
  EXPECT_EQ(found("B0", "front", ""), "no vehicle is named, and there is not just one");
}

TEST(BeaconDelayPrior, IsTheBeaconsOwnWhereItStatesOne) {
  Site site = hall_scenario().site;
  site.timing.delay_s = 1e-4;
  site.timing.delay_sigma_s = 5e-5;
  site.beacons[2].delay_s = 3e-4;
  site.beacons[3].delay_sigma_s = 8e-5;
  EXPECT_EQ(beacon_delay_prior(site, 0).value, 1e-4);
  EXPECT_EQ(beacon_delay_prior(site, 2).value, 3e-4);
  EXPECT_EQ(beacon_delay_prior(site, 2).sigma, 5e-5) << "and timing's for what it does not";
  EXPECT_EQ(beacon_delay_prior(site, 3).value, 1e-4);
  EXPECT_EQ(beacon_delay_prior(site, 3).sigma, 8e-5);
}

TEST(LargestDelaySigma, IsOfTheDelaysInUse) {
  Site site = hall_scenario().site;
  site.timing.delay_sigma_s = 5e-5;
  site.beacons[3].delay_sigma_s = 8e-5;
  for (SiteBeacon& b : site.beacons)
    if (!b.delay_sigma_s) b.delay_sigma_s = 1e-6;
  EXPECT_EQ(largest_delay_sigma_s(site), 8e-5);
  site.timing.delay_per = {.site = true};
  EXPECT_EQ(largest_delay_sigma_s(site), 5e-5) << "what beacons state is not in use";
  site.timing.delay_per = {};
  EXPECT_EQ(largest_delay_sigma_s(site), 0.0);
}

TEST(SiteBeacon, IsAControlPointWhereAllThreeCoordinatesAreHeld) {
  SiteBeacon b = beacon("B", {1, 2, 3}, 0.0);
  EXPECT_TRUE(b.is_control_point());
  b.sigma_m[2] = 0.01;
  EXPECT_FALSE(b.is_control_point());
  b.sigma_m[2].reset();
  EXPECT_FALSE(b.is_control_point());
  b = beacon("B", {1, 2, 3}, 0.0);
  b.position_m[0].reset();
  EXPECT_FALSE(b.is_control_point());
}

RC_GTEST_PROP(OdometryStep, HoldsAnyPoseAndTellsThePlane, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Pose T{draws.normal3(), exp_rotation(draws.normal3())};
  OdometryStep step;
  step.set_pose(T);
  RC_ASSERT((step.pose().translation_m - T.translation_m).norm() < 1e-15);
  RC_ASSERT(step.pose().rotation.angularDistance(T.rotation) < 1e-7);
  RC_ASSERT(!step.is_planar() && !step.is_zero() && step.is_finite());
  const Pose flat = Pose::planar(draws.normal(), draws.normal(), draws.uniform(-3, 3));
  step.set_pose(flat);
  RC_ASSERT(step.is_planar());
  RC_ASSERT((step.pose().translation_m - flat.translation_m).norm() < 1e-15);
  RC_ASSERT(std::abs(step.dheading_rad - flat.heading_rad()) < 1e-14);
}

TEST(OdometryStep, ThatStandsIsZeroAndNoNumberIsNone) {
  OdometryStep step;
  EXPECT_TRUE(step.is_zero());
  step.turn_x_rad = 1e-300;
  EXPECT_FALSE(step.is_zero());
  for (double OdometryStep::*member :
       {&OdometryStep::dx_m, &OdometryStep::dy_m, &OdometryStep::dz_m, &OdometryStep::dheading_rad,
        &OdometryStep::turn_x_rad, &OdometryStep::turn_y_rad}) {
    OdometryStep broken;
    broken.*member = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(broken.is_finite());
  }
}

Fix ok_fix() {
  Fix fix;
  fix.status = FixStatus::kOk;
  fix.protection_level_m = 0.4;
  fix.covariance = Eigen::Matrix3d::Identity() * 0.01;
  return fix;
}

TEST(Integrity, OfAFixIsItsProtection) {
  Fix fix = ok_fix();
  EXPECT_EQ(integrity(fix), Integrity::kOk);
  EXPECT_STREQ(integrity_reason(fix), "");
  fix.rejections = {Rejection::kUsed, Rejection::kLate};
  EXPECT_EQ(integrity(fix), Integrity::kOk) << "an echo left out is no fault";
  fix.rejections.push_back(Rejection::kBeaconFault);
  EXPECT_EQ(integrity(fix), Integrity::kDegraded);
  EXPECT_STREQ(integrity_reason(fix), "beacon_fault");
  for (const double level : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
    fix = ok_fix();
    fix.protection_level_m = level;
    EXPECT_EQ(integrity(fix), Integrity::kDegraded);
    EXPECT_STREQ(integrity_reason(fix), "not_protected");
  }
  fix.status = FixStatus::kAmbiguous;
  EXPECT_EQ(integrity(fix), Integrity::kNoFix);
  EXPECT_STREQ(integrity_reason(fix), "ambiguous");
}

TEST(Words, OfEveryEnumeratorAreItsOwn) {
  std::set<std::string> words;
  for (int i = 0; i <= static_cast<int>(FixStatus::kNotConverged); ++i)
    words.insert(to_string(static_cast<FixStatus>(i)));
  EXPECT_EQ(words.size(), 6U);
  words.clear();
  for (int i = 0; i <= static_cast<int>(Rejection::kBeaconFault); ++i)
    words.insert(to_string(static_cast<Rejection>(i)));
  EXPECT_EQ(words.size(), 12U);
  words.clear();
  for (int i = 0; i <= static_cast<int>(BeaconStatus::kUndetermined); ++i)
    words.insert(to_string(static_cast<BeaconStatus>(i)));
  EXPECT_EQ(words, (std::set<std::string>{"calibrated", "control_point", "undetermined"}));
}

struct PlainRow {
  bool ok;
  double time_s;
  int vehicle, arrivals_used, arrivals_rejected;
  double x_m, y_m, z_m, heading_rad, qx, qy, qz, qw, sigma_x_m, sigma_y_m, sigma_heading_rad,
      protection_level_m;
  double covariance[6][6], velocity_mps[3], turn_rate_radps[3], sigma_velocity_mps[3],
      sigma_turn_rate_radps[3];
};

TEST(PlainFix, IsTheFixInNumbers) {
  Fix fix = ok_fix();
  fix.T_map_vehicle = Pose::planar(1, 2, 0.5);
  fix.covariance.diagonal() << 0.04, 0.09, 0.0016;
  fix.arrivals_used = 7;
  fix.vehicle = VehicleId(1);
  PlainRow row{};
  EXPECT_TRUE(fill_row(fix, row));
  EXPECT_EQ(row.x_m, 1.0);
  EXPECT_NEAR(row.heading_rad, 0.5, 1e-15);
  EXPECT_DOUBLE_EQ(row.sigma_x_m, 0.2);
  EXPECT_DOUBLE_EQ(row.sigma_y_m, 0.3);
  EXPECT_DOUBLE_EQ(row.sigma_heading_rad, 0.04);
  EXPECT_NEAR(row.qw, std::cos(0.25), 1e-15);
  EXPECT_EQ(row.vehicle, 1);
  EXPECT_EQ(row.arrivals_used, 7);
  fix.covariance(2, 2) = 100.0;  // an angle is never known worse than any
  EXPECT_TRUE(fill_row(fix, row));
  EXPECT_DOUBLE_EQ(row.sigma_heading_rad, M_PI);
  fix.covariance = Eigen::Matrix<double, 6, 6>::Identity();
  fix.covariance(5, 5) = 0.25;  // in space the third rotation
  EXPECT_TRUE(fill_row(fix, row));
  EXPECT_DOUBLE_EQ(row.sigma_heading_rad, 0.5);
}

TEST(PlainFix, HasTheCovarianceInTheMapAndTheVelocityInTheVehicle) {
  Fix fix = ok_fix();
  fix.T_map_vehicle.rotation = exp_rotation({0.0, 0.0, M_PI / 2});
  fix.covariance = Eigen::Matrix<double, 6, 6>::Zero();
  fix.covariance.diagonal() << 1, 2, 3, 4, 5, 6;
  fix.covariance(0, 3) = fix.covariance(3, 0) = 0.5;  // of x and a rotation about x of the vehicle
  PlainRow row{};
  row.velocity_mps[0] = 42.0;
  EXPECT_TRUE(fill_row(fix, row));
  EXPECT_EQ(row.velocity_mps[0], 42.0) << "unknown";
  EXPECT_NEAR(row.covariance[4][4], 4.0, 1e-12);  // the vehicle's x is the map's y
  EXPECT_NEAR(row.covariance[3][3], 5.0, 1e-12);
  EXPECT_NEAR(row.covariance[0][4], 0.5, 1e-12);
  fix.velocity = VelocityEstimate{};
  fix.velocity->mean << 1, 2, 3, 4, 5, 6;
  fix.velocity->variance << 1, 4, 9, 16, 25, 36;
  EXPECT_TRUE(fill_row(fix, row));
  EXPECT_EQ(row.velocity_mps[1], 2.0);
  EXPECT_EQ(row.turn_rate_radps[2], 6.0);
  EXPECT_EQ(row.sigma_velocity_mps[2], 3.0);
  EXPECT_EQ(row.sigma_turn_rate_radps[0], 4.0);
}

TEST(PlainFix, OfNoneLeavesThePlaceAsItWas) {
  PlainRow row{};
  row.x_m = 42.0;
  Fix fix;
  fix.time_s = 3.0;
  fix.arrivals_rejected = 2;
  EXPECT_FALSE(fill_row(fix, row));
  EXPECT_FALSE(row.ok);
  EXPECT_EQ(row.x_m, 42.0);
  EXPECT_EQ(row.time_s, 3.0);
  EXPECT_EQ(row.arrivals_rejected, 2);
}

}  // namespace vocabulary_test
}  // namespace octant::test
