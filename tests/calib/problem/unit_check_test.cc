// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Ranges by the site's statements; which units are suspected in a hall: tests/calib/plan/check_test.cc.
#include "calib/problem/unit_check.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/problem/ranges.h"
#include "tests/calib/at_truth.h"

namespace octant::test {
namespace unit_check_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A hall without noise in which everything agrees with the site file.
Scenario as_stated() {
  Scenario s = without_noise(hall_scenario());
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {0.0, 0.0, 0.0};
  for (SiteReceiver& r : s.site.receivers) r.sigma_m.setZero();
  s.site.speed_sigma_mps = 0.0;
  s.site.timing.delay_sigma_s = 0.0;
  s.true_temperature_offset_degC.reset();
  s.true_delay_s.reset();
  s.path.epochs = 12;
  return s;
}

/// Every stated range is the distance from the beacon to the receiver where it truly was.
void expect_true_ranges(const Scenario& scenario) {
  const World world = must(simulate(scenario, 2));
  ASSERT_GT(world.run.arrivals.size(), 50U);
  for (const Arrival& a : world.run.arrivals) {
    Pose T;
    ASSERT_TRUE(interpolate_poses(world.run.truth, a.time_s, 10.0, T));
    const double distance_m = (T * world.truth.receivers[a.receiver.index()].position_m -
                               world.truth.beacons[a.beacon.index()].position_m)
                                  .norm();
    // Times without a common step: rounding of some milliseconds times 345 m/s.
    EXPECT_NEAR(calib::stated_range_m(world.site, world.run, a), distance_m, 1e-9);
  }
}

TEST(StatedRange, IsTheDistanceWhereAllIsAsStated) { expect_true_ranges(as_stated()); }

// The prior mean applies once, to the first kind of delay in use; it is fixed for all if no kind is free.
TEST(StatedRange, TakesTheStatedDelayOnceWhoeverHasIt) {
  const DelayPer kinds[] = {{.beacon = true},
                            {.receiver = true},
                            {.site = true},
                            {},
                            {.beacon = true, .receiver = true},
                            {.beacon = true, .receiver = true, .site = true},
                            {.receiver = true, .site = true}};
  for (const DelayPer& per : kinds) {
    SCOPED_TRACE(testing::Message() << per.beacon << per.receiver << per.site);
    Scenario s = as_stated();
    s.site.timing.delay_per = per;
    s.site.timing.delay_s = 2e-3;  // 0.7 m
    expect_true_ranges(s);
  }
}

TEST(StatedRange, TakesABeaconsOwnDelay) {
  Scenario s = as_stated();
  s.site.beacons[3].delay_s = 5e-3;
  s.site.beacons[5].delay_s = -1e-3;
  expect_true_ranges(s);
}

TEST(StatedRange, OfTwoWayRangingIsHalfTheWay) {
  Scenario s = as_stated();
  s.site.timing.ranging = Ranging::kTwoWay;
  s.site.timing.turnaround_s = 0.01;
  expect_true_ranges(s);
}

TEST(StatedRange, TakesTheTemperatureOfTheArrivalElseTheRunsElseTheSites) {
  Site site = as_stated().site;
  site.timing.delay_s = 0.0;
  MeasurementLog run;
  Arrival a;
  a.tof_s = 0.02;
  a.beacon = BeaconId(0);
  a.receiver = ReceiverId(0);
  const auto at = [&](double degC) { return 0.02 * speed_mps(site.medium, degC); };
  EXPECT_DOUBLE_EQ(calib::stated_range_m(site, run, a), at(21.0));
  run.temperature_degC = 5.0;
  EXPECT_DOUBLE_EQ(calib::stated_range_m(site, run, a), at(5.0));
  a.temperature_degC = 30.0;
  EXPECT_DOUBLE_EQ(calib::stated_range_m(site, run, a), at(30.0));
  run.relative_humidity = 0.9;
  Medium humid = site.medium;
  humid.relative_humidity = 0.9;
  EXPECT_DOUBLE_EQ(calib::stated_range_m(site, run, a), 0.02 * speed_mps(humid, 30.0));
}

TEST(StatedRange, IsNotNegative) {
  const Site site = as_stated().site;
  Arrival a;
  a.tof_s = 0.5e-4;  // shorter than its delay
  a.beacon = BeaconId(0);
  a.receiver = ReceiverId(0);
  EXPECT_EQ(calib::stated_range_m(site, MeasurementLog(), a), 0.0);
}

/// Ranging by radio: a delay of 300 ns is 90 m, many times the site.
Scenario radio_with_a_long_delay() {
  Scenario s = as_stated();
  s.site.medium = {.model = MediumModel::kConstant, .speed_mps = 299702547.0};
  s.site.timing.delay_s = 300e-9;
  s.site.noise.tof_sigma_s = 1e-10;
  s.hearing_half_angle_rad = 3.2;
  s.path.epochs = 30;
  return s;
}

TEST(UnitCheck, ALongDelayThatIsStatedIsNoUnitAndNoFactor) {
  for (const DelayPer& per :
       {DelayPer{.beacon = true}, DelayPer{}, DelayPer{.beacon = true, .receiver = true}}) {
    Scenario s = radio_with_a_long_delay();
    s.site.timing.delay_per = per;
    const World world = must(simulate(s, 3));
    EXPECT_THAT(calib::check_units(world.site, world.run), IsEmpty()) << per.beacon << per.receiver;
  }
}

TEST(UnitCheck, NeitherIsATurnaround) {
  Scenario s = radio_with_a_long_delay();
  s.site.timing.ranging = Ranging::kTwoWay;
  s.site.timing.turnaround_s = 2e-4;  // 30 km
  const World world = must(simulate(s, 3));
  EXPECT_THAT(calib::check_units(world.site, world.run), IsEmpty());
}

TEST(UnitCheck, AUnitIsNamedBehindALongDelayToo) {
  World world = must(simulate(radio_with_a_long_delay(), 3));
  for (Arrival& a : world.run.arrivals) a.tof_s *= 1e9;
  const auto found = calib::check_units(world.site, world.run);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].kind, "unit");
}

TEST(UnitCheck, SaysNothingWithoutArrivalsOrAnExtent) {
  const World world = must(simulate(as_stated(), 2));
  EXPECT_THAT(calib::check_units(world.site, MeasurementLog()), IsEmpty());
  Site unknown = world.site;
  for (SiteBeacon& b : unknown.beacons) b.position_m = {};
  MeasurementLog run = world.run;
  for (Arrival& a : run.arrivals) a.tof_s *= 1000;
  run.poses.clear();
  EXPECT_THAT(calib::check_units(unknown, run), IsEmpty()) << "nothing to hold the ranges against";
  unknown.distances.push_back({BeaconId(0), BeaconId(1), 8.0, 0.01});
  EXPECT_THAT(calib::check_units(unknown, run), SizeIs(1)) << "a tape is an extent";
}

TEST(UnitCheck, TimesFarTooShortAreSuspectedOfNoUnitByName) {
  World world = must(simulate(as_stated(), 2));
  for (Arrival& a : world.run.arrivals) a.tof_s *= 1e-4;
  const auto found = calib::check_units(world.site, world.run);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("check the unit of tof_s and medium.speed_mps"));
  world.site.timing.clock = Clock::kCycleOffset;  // times are those of a cycle, and may be any
  EXPECT_THAT(calib::check_units(world.site, world.run), IsEmpty());
}

TEST(UnitCheck, MillimetresAreNamed) {
  World world = must(simulate(as_stated(), 2));
  for (Arrival& a : world.run.arrivals) a.tof_s *= 345.0 * 1000;
  const auto found = calib::check_units(world.site, world.run);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("millimetres"));
}

}  // namespace unit_check_test
}  // namespace octant::test
