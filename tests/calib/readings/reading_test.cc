// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// What each other reading makes of a site; which of them is found: tests/calib/readings/readings_test.cc.
#include "calib/readings/reading.h"

#include <cmath>
#include <set>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "calib/readings/pose_frames.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

Site hall_site() { return hall_scenario().site; }

TEST(OtherRanging, IsTheOtherOneAndBackAgain) {
  const Site site = hall_site();
  const auto readings = calib::other_ranging(site);
  ASSERT_EQ(readings.size(), 1U);
  const Site two_way = readings[0].site(site);
  EXPECT_EQ(two_way.timing.ranging, Ranging::kTwoWay);
  EXPECT_EQ(readings[0].what.kind, ContradictionKind::kRanging);
  EXPECT_EQ(readings[0].what.stated, "one_way");
  EXPECT_FALSE(readings[0].log) << "the recordings are as they are";
  const auto back = calib::other_ranging(two_way);
  EXPECT_EQ(back[0].site(two_way).timing.ranging, Ranging::kOneWay);
  EXPECT_EQ(back[0].what.stated, "two_way");
}

TEST(OtherRanging, IsNoneWhereEachEpochHasAClockOfItsOwn) {
  Site site = hall_site();
  site.timing.clock = Clock::kCycleOffset;
  EXPECT_TRUE(calib::other_ranging(site).empty());
}

// Each convention in which odometry may be written is read back by the reading that names it.
TEST(OtherOdometry, ReadsEachConventionBack) {
  MeasurementLog log;
  for (int i = 0; i < 5; ++i)
    log.odometry.push_back({0.1 * i, 0.02 + 0.001 * i, 0.003, -0.01 * i, VehicleId(0)});
  const auto readings = calib::other_odometry({log});
  ASSERT_EQ(readings.size(), 7U);
  const std::tuple<const char*, double, double, double> written[] = {
      {"turns count clockwise", 1.0, 1.0, -1.0},
      {"way backward", -1.0, 1.0, 1.0},
      {"y counts to the right", 1.0, -1.0, -1.0},
      {"backward and turns", -1.0, 1.0, -1.0},
      {"degrees", 1.0, 1.0, 180.0 / M_PI},
      {"millimetres", 1e3, 1e3, 1.0},
      {"centimetres", 1e2, 1e2, 1.0}};
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const auto& [words, way, side, turn] = written[k];
    EXPECT_NE(readings[k].what.found.find(words), std::string::npos) << readings[k].what.found;
    EXPECT_TRUE(readings[k].is_of_whole) << "rows of another convention do not sum up";
    MeasurementLog other = log;
    for (OdometryStep& step : other.odometry) {
      step.dx_m *= way;
      step.dy_m *= side;
      step.dheading_rad *= turn;
    }
    readings[k].log(0, other);
    for (std::size_t i = 0; i < log.odometry.size(); ++i) {
      EXPECT_NEAR(other.odometry[i].dx_m, log.odometry[i].dx_m, 1e-15) << words;
      EXPECT_NEAR(other.odometry[i].dy_m, log.odometry[i].dy_m, 1e-15) << words;
      EXPECT_NEAR(other.odometry[i].dheading_rad, log.odometry[i].dheading_rad, 1e-15) << words;
    }
  }
}

TEST(OtherOdometry, IsNoneWithoutOdometryOrInSpace) {
  MeasurementLog log;
  EXPECT_TRUE(calib::other_odometry({log}).empty());
  OdometryStep up;
  up.dz_m = 0.1;
  log.odometry = {up};
  EXPECT_TRUE(calib::other_odometry({log}).empty());
}

TEST(WithoutPoses, LeavesThoseOfDrives) {
  MeasurementLog stops, drive;
  stops.has_epochs = true;
  stops.poses.resize(3);
  drive.poses.resize(3);
  EXPECT_TRUE(calib::without_poses({drive}).empty());
  const auto readings = calib::without_poses({drive, stops});
  ASSERT_EQ(readings.size(), 1U);
  readings[0].log(0, drive);
  readings[0].log(1, stops);
  EXPECT_EQ(drive.poses.size(), 3U);
  EXPECT_TRUE(stops.poses.empty());
}

TEST(OtherUnits, ScaleBeaconsReceiversOrBoth) {
  const Site site = hall_site();
  const auto readings = calib::other_units(site, {}, false);
  std::set<double> factors;
  bool beacons_alone = false, receivers_alone = false, both = false;
  for (const calib::Reading& reading : readings) {
    const Site other = reading.site(site);
    const double b = *other.beacons[3].position_m[0] / *site.beacons[3].position_m[0],
                 r = other.receivers[2].position_m.x() / site.receivers[2].position_m.x();
    for (std::size_t i = 0; i < 8; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(*other.beacons[i].position_m[k], b * *site.beacons[i].position_m[k], 1e-12);
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_LT((other.receivers[i].position_m - r * site.receivers[i].position_m).norm(), 1e-12);
    EXPECT_EQ(reading.what.kind, ContradictionKind::kUnits);
    beacons_alone = beacons_alone || (b != 1 && r == 1);
    receivers_alone = receivers_alone || (b == 1 && r != 1);
    both = both || (b != 1 && b == r);
    factors.insert(b != 1 ? b : r);
  }
  EXPECT_TRUE(beacons_alone && receivers_alone && both);
  for (const double unit_m : {0.01, 0.001, 0.3048, 0.0254}) {  // international foot and inch
    bool there = false;
    for (const double f : factors) there = there || std::abs(f - unit_m) < 1e-12;
    EXPECT_TRUE(there) << unit_m;
  }
}

TEST(OtherUnits, OfBeaconsWithoutPlacesAreOfReceiversAlone) {
  Site site = hall_site();
  for (SiteBeacon& b : site.beacons) b.position_m = {};
  for (const calib::Reading& reading : calib::other_units(site, {}, false))
    EXPECT_NE(reading.site(site).receivers[2].position_m, site.receivers[2].position_m);
  EXPECT_TRUE(calib::other_units(site, {}, true).empty());
}

TEST(OtherUnits, OfAHallInMetresHaveNoOddOnes) {
  EXPECT_TRUE(calib::other_units(hall_site(), {}, true).empty());
}

TEST(OtherUnits, NameTheBeaconsThatAloneAreOfAnotherMagnitude) {
  Site site = hall_site();
  for (const std::size_t b : {2U, 5U})
    for (auto& x : site.beacons[b].position_m) *x *= 100.0;
  bool mended = false;
  for (const calib::Reading& reading : calib::other_units(site, {}, true)) {
    if (reading.what.subject.find("B2, B5") == std::string::npos) continue;
    const Site other = reading.site(site);
    EXPECT_EQ(*other.beacons[1].position_m[0], *site.beacons[1].position_m[0]) << "the rest stays";
    mended =
        mended || std::abs(*other.beacons[5].position_m[0] - *hall_site().beacons[5].position_m[0]) < 1e-9;
  }
  EXPECT_TRUE(mended);
}

TEST(ExchangedPoints, AreEveryPairOfAFewControlPoints) {
  Site site = hall_site();  // B0, B3, B6
  const auto readings = calib::exchanged_points(site);
  ASSERT_EQ(readings.size(), 3U);
  std::set<std::string> names;
  for (const calib::Reading& reading : readings) names.insert(reading.what.subject);
  EXPECT_EQ(names, (std::set<std::string>{"B0, B3", "B0, B6", "B3, B6"}));
  const Site other = readings[0].site(site);
  EXPECT_EQ(other.beacons[0].position_m, site.beacons[3].position_m);
  EXPECT_EQ(other.beacons[3].position_m, site.beacons[0].position_m);
  EXPECT_EQ(other.beacons[6].position_m, site.beacons[6].position_m);
  EXPECT_EQ(other.beacons[0].name, "B0");
  for (const std::size_t b : {1U, 2U}) site.beacons[b].sigma_m = {0.0, 0.0, 0.0};
  EXPECT_TRUE(calib::exchanged_points(site).empty()) << "five are more than a few";
}

TEST(OtherPoseFrames, AreNoneWithoutPoses) {
  EXPECT_TRUE(calib::other_pose_frames({}).empty());
  EXPECT_TRUE(calib::other_pose_frames(std::vector<MeasurementLog>(2)).empty());
}

TEST(OtherPoseFrames, MirrorEveryPoseOfEveryRun) {
  std::vector<MeasurementLog> runs(2);
  runs[1].poses = {{0.0, Pose::planar(1, 2, 0.3)}, {1.0, Pose::planar(3, -1, 2.0)}};
  const auto readings = calib::other_pose_frames(runs);
  ASSERT_EQ(readings.size(), calib::reflections().size());
  for (std::size_t k = 0; k < readings.size(); ++k) {
    MeasurementLog run = runs[1];
    readings[k].log(1, run);
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_EQ(run.poses[i].T_map_vehicle.translation_m,
                calib::reflections()[k].read(runs[1].poses[i].T_map_vehicle).translation_m);
  }
}

TEST(PosesOfOtherClock, AreReadAsTheArrivalsClockWouldHaveThem) {
  std::vector<MeasurementLog> runs(1);
  runs[0].path = "run";
  runs[0].poses = {{1.0, Pose::planar(1, 2, 0.3)}, {2.0, Pose::planar(3, -1, 2.0)}};
  const calib::Reading late = calib::poses_of_other_clock(runs, 0.25),
                       early = calib::poses_of_other_clock(runs, -0.25);
  MeasurementLog run = runs[0];
  late.log(0, run);
  EXPECT_EQ(run.poses[1].time_s, 1.75);
  early.log(0, run);
  EXPECT_EQ(run.poses[1].time_s, 2.0);
  EXPECT_NE(late.what.found.find("0.25 s late"), std::string::npos);
  EXPECT_NE(late.what.remedy.find("subtract 0.25 s from each time of run/poses.tum"), std::string::npos);
  EXPECT_NE(early.what.remedy.find("add 0.25 s to each time of run/poses.tum"), std::string::npos);
}

TEST(PosesOfOtherPoint, AreReadAsTheOriginHasThem) {
  std::vector<MeasurementLog> runs(1);
  const Pose origin = Pose::planar(1, 2, M_PI / 2);
  const Eigen::Vector3d prism(0.4, 0.1, 0.0);
  runs[0].poses = {{1.0, {origin * prism, origin.rotation}}};
  calib::poses_of_other_point(runs, prism).log(0, runs[0]);
  EXPECT_LT((runs[0].poses[0].T_map_vehicle.translation_m - origin.translation_m).norm(), 1e-12);
}

}  // namespace
}  // namespace octant::test
