// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Jumps in simulated recordings, as found by each check.
#include "calib/problem/clock_check.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "tests/calib/at_truth.h"

namespace octant::test {
namespace clock_check_test {

constexpr double kJumpS = 4e-3;  // 1.4 m of sound

void put_jump(MeasurementLog& run, double at_s, double by_s) {
  for (Arrival& a : run.arrivals)
    if (a.time_s >= at_s) a.tof_s += by_s;
}
void put_jump(std::vector<Trajectory>& trajectories, double at_s, double by_s) {
  for (Trajectory& t : trajectories)
    for (ArrivalObservation& a : t.arrivals)
      if (a.time_s >= at_s) a.tof_s += by_s;
}

/// A vehicle that hardly moves between one firing of a beacon and the next.
Scenario slow_drive() {
  Scenario s = drive_scenario(60.0);
  s.path.speed_mps = 0.2;
  s.path.turn_rate_rad_per_s = 0.3;
  return s;
}

TEST(StepsInRanges, OfAnHonestDriveAreNone) {
  const World world = must(simulate(slow_drive(), 1));
  EXPECT_TRUE(calib::steps_in_ranges(world.site, world.run).empty());
  EXPECT_FALSE(calib::ranges_show_a_jump(world.site, {world.run, world.run}));
}

TEST(StepsInRanges, AreFoundWhereAndByHowMuchTheClockJumped) {
  for (const double by_s : {2 * kJumpS, -2 * kJumpS}) {
    World world = must(simulate(slow_drive(), 1));
    for (Arrival& a : world.run.arrivals) a.tof_s += 0.05;  // so that no time is negative
    world.site.timing.delay_s += 0.05;
    put_jump(world.run, 30.0, by_s);
    const auto steps = calib::steps_in_ranges(world.site, world.run);
    ASSERT_EQ(steps.size(), 1U) << by_s;
    EXPECT_NEAR(steps[0].time_s, 30.0, 1.0) << "a round of the beacons";
    // The median of ranges that the vehicle's own motion of some decimetres changes too.
    EXPECT_NEAR(steps[0].step_s, by_s, 1e-3);
    EXPECT_GE(steps[0].beacons, 3U);
    EXPECT_TRUE(calib::ranges_show_a_jump(world.site, {world.run}));
  }
}

TEST(StepsInRanges, OfTwoWayRangingCountTheWayOnce) {
  Scenario s = slow_drive();
  s.site.timing.ranging = Ranging::kTwoWay;
  World world = must(simulate(s, 1));
  put_jump(world.run, 30.0, 4 * kJumpS);
  const auto steps = calib::steps_in_ranges(world.site, world.run);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_NEAR(steps[0].step_s, 4 * kJumpS, 2e-3) << "as the times of flight have it";
}

TEST(StepsInRanges, AnEchoThatComesAndGoesIsNone) {
  World world = must(simulate(slow_drive(), 1));
  // All beacons late at all receivers, each once.
  std::set<std::pair<BeaconId, ReceiverId>> done;
  for (Arrival& a : world.run.arrivals)
    if (a.time_s >= 30.0 && done.insert({a.beacon, a.receiver}).second) a.tof_s += 2 * kJumpS;
  EXPECT_TRUE(calib::steps_in_ranges(world.site, world.run).empty());
}

TEST(StepsInRanges, OfOneBeaconAreNone) {
  World world = must(simulate(slow_drive(), 1));
  for (Arrival& a : world.run.arrivals)
    if (a.beacon == BeaconId(2) && a.time_s > 30.0) a.tof_s += 2 * kJumpS;
  EXPECT_TRUE(calib::steps_in_ranges(world.site, world.run).empty());
}

TEST(StepsInRanges, AreNotLookedForWhereEachEpochHasItsOwnClock) {
  World world = must(simulate(slow_drive(), 1));
  put_jump(world.run, 30.0, 2 * kJumpS);
  world.site.timing.clock = Clock::kCycleOffset;
  EXPECT_TRUE(calib::steps_in_ranges(world.site, world.run).empty());
}

Scenario stops() {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  s.hearing_half_angle_rad = 3.2;  // all beacons at all receivers
  s.range_m = 30.0;
  return s;
}

TEST(StepsBetweenStops, AreFoundAtTheStopWhereTheyBegin) {
  for (const double by_s : {kJumpS, -kJumpS}) {
    AtTruth at(stops(), 2);
    const double at_s = at.trajectories[0].nodes[25].time_s - 1.0;
    put_jump(at.trajectories, at_s, by_s);
    const auto steps = calib::steps_between_stops(at.trajectories, 0, at.state);
    ASSERT_EQ(steps.size(), 1U) << by_s;
    EXPECT_EQ(steps[0].time_s, at.trajectories[0].nodes[25].time_s);
    // Medians over eight stops of some forty arrivals of 10 us each.
    EXPECT_NEAR(steps[0].step_s, by_s, 1e-5);
  }
}

TEST(StepsBetweenStops, TwoOfThemAreTwo) {
  AtTruth at(stops(), 2);
  const auto& nodes = at.trajectories[0].nodes;
  put_jump(at.trajectories, nodes[20].time_s - 1.0, kJumpS);
  put_jump(at.trajectories, nodes[40].time_s - 1.0, -0.5 * kJumpS);
  const auto steps = calib::steps_between_stops(at.trajectories, 0, at.state);
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_EQ(steps[0].time_s, nodes[20].time_s);
  EXPECT_NEAR(steps[0].step_s, kJumpS, 2e-5);
  EXPECT_EQ(steps[1].time_s, nodes[40].time_s);
  EXPECT_NEAR(steps[1].step_s, -0.5 * kJumpS, 2e-5);
}

TEST(StepsBetweenStops, OfAnHonestLogOrBelowTheSmallestAreNone) {
  AtTruth at(stops(), 2);
  EXPECT_TRUE(calib::steps_between_stops(at.trajectories, 0, at.state).empty());
  put_jump(at.trajectories, at.trajectories[0].nodes[25].time_s - 1.0, 2e-4);  // 69 mm
  EXPECT_TRUE(calib::steps_between_stops(at.trajectories, 0, at.state).empty());
  EXPECT_EQ(calib::steps_between_stops(at.trajectories, 0, at.state, 0.03).size(), 1U);
  EXPECT_TRUE(calib::steps_between_stops(at.trajectories, 1, at.state, 0.03).empty()) << "another run";
}

TEST(StepsBetweenStops, AreSeenThroughArrivalsThatWereRejectedForThem) {
  AtTruth at(stops(), 2);
  const double at_s = at.trajectories[0].nodes[25].time_s - 1.0;
  put_jump(at.trajectories, at_s, kJumpS);
  for (ArrivalObservation& a : at.trajectories[0].arrivals)
    if (a.time_s >= at_s) a.rejection = Rejection::kLate;
  EXPECT_EQ(calib::steps_between_stops(at.trajectories, 0, at.state).size(), 1U);
}

TEST(StepsBetweenStops, NeedFourBeaconsForAPlaceAndAClock) {
  AtTruth at(stops(), 2);
  for (ArrivalObservation& a : at.trajectories[0].arrivals)
    if (a.beacon.index() >= 3) a.rejection = Rejection::kBeaconUnusable;
  put_jump(at.trajectories, at.trajectories[0].nodes[25].time_s - 1.0, kJumpS);
  EXPECT_TRUE(calib::steps_between_stops(at.trajectories, 0, at.state).empty());
}

TEST(StepsAlongDrives, AreFoundToTheArrival) {
  Scenario s = drive_scenario(120.0);
  s.hearing_half_angle_rad = 3.2;
  AtTruth at(s, 3);
  EXPECT_TRUE(calib::steps_along_drives(at.trajectories, at.state, 0.05).empty());
  const auto& arrivals = at.trajectories[0].arrivals;
  const double at_s = arrivals[arrivals.size() / 2].time_s;
  put_jump(at.trajectories, at_s, 5e-4);
  const auto steps = calib::steps_along_drives(at.trajectories, at.state, 0.05);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0].time_s, at_s);
  EXPECT_NEAR(steps[0].step_s, 5e-4, 1e-5);  // medians of 32 arrivals of 10 us
  EXPECT_TRUE(calib::steps_along_drives(at.trajectories, at.state, 0.3).empty()) << "172 mm are below that";
}

}  // namespace clock_check_test
}  // namespace octant::test
