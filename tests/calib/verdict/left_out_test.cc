// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/left_out.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/at_truth.h"

namespace octant::test {
namespace left_out_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Stops without noise that receive beacons, observe them as reflectors and know their poses.
Scenario stops() {
  Scenario s = without_noise(hall_scenario());
  s.path.epochs = 10;
  s.log_poses = true;
  s.bearings = Scenario::Bearings{};
  s.site.noise.bearing_sigma_rad = 1e-3;
  return s;
}

struct Stops : AtTruth {
  Stops() : AtTruth(stops(), 1) {
    for (ArrivalObservation& a : t().arrivals) a.sigma_s = 1e-5;
  }
  Trajectory& t() { return trajectories[0]; }
  [[nodiscard]] calib::LeftOutOfAll left_out() const {
    return calib::left_out_of(problem, trajectories, state);
  }
};

TEST(LeftOut, OfAllThatIsUsedIsNothingButPosesThatNobodyNeeds) {
  const Stops stops;
  const calib::LeftOutOfAll out = stops.left_out();
  EXPECT_THAT(out.arrivals, IsEmpty());
  EXPECT_THAT(out.bearings, IsEmpty());
}

TEST(LeftOut, ArrivalsCarryTheirReasonAndBySoMuch) {
  Stops stops;
  std::vector<ArrivalObservation>& a = stops.t().arrivals;
  const auto leave = [&](std::size_t i, Rejection why, double late_s) {
    a[i].rejection = why;
    a[i].tof_s += late_s;
  };
  leave(3, Rejection::kLate, 2e-3);
  leave(7, Rejection::kEarly, -1e-3);
  leave(9, Rejection::kTriangle, 4e-3);
  leave(11, Rejection::kBeaconUnusable, 5e-3);
  stops.t().stateless_arrivals = {42};
  const auto out = stops.left_out().arrivals;
  ASSERT_EQ(out.size(), 5U);
  EXPECT_EQ(out[0].arrival, 42U);
  EXPECT_EQ(out[0].reason, Rejection::kNoPose);
  const std::size_t at[] = {3, 7, 9, 11};
  // An unusable beacon, whose position is wrong, has no meaningful residual.
  const double late_s[] = {2e-3, -1e-3, 4e-3, 0.0};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(out[i + 1].arrival, a[at[i]].arrival);
    EXPECT_EQ(out[i + 1].reason, a[at[i]].rejection);
    EXPECT_NEAR(out[i + 1].residual_s, late_s[i], 1e-12);  // roundings of times of tens of milliseconds
  }
}

TEST(LeftOut, BearingsTooAndThoseThatNoStateCarries) {
  Stops stops;
  std::vector<BearingObservation>& b = stops.t().bearings;
  ASSERT_GT(b.size(), 20U);
  b[2].rejection = Rejection::kLate;
  b[2].bearing_rad += 0.2;
  const std::size_t gone = b[5].bearing;
  b.erase(b.begin() + 5);
  for (Segment& s : stops.t().segments) {
    if (s.first_bearing > 5) --s.first_bearing;
    if (s.last_bearing > 5) --s.last_bearing;
  }
  const auto out = stops.left_out().bearings;
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].bearing, b[2].bearing);
  EXPECT_EQ(out[1].bearing, gone);
  EXPECT_EQ(out[1].reason, Rejection::kNoPose);
}

TEST(LeftOut, PosesAreNeededWhereAnObservationLiesBetweenThem) {
  calib::Problem problem;
  problem.runs.resize(1);
  MeasurementLog& log = problem.runs[0];
  log.pose_accuracy.max_gap_s = 1.5;
  for (const double t : {0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 7.0, 8.0}) log.poses.push_back({t, Pose()});
  const auto hear = [&](double time_s) {
    Arrival a;
    a.time_s = time_s;
    log.arrivals.push_back(a);
  };
  hear(1.4);  // between the second and the third
  hear(3.0);  // at one
  hear(5.0);  // across too long a gap
  hear(9.0);  // behind the last
  Bearing b;
  b.time_s = 7.2;
  log.bearings.push_back(b);
  Trajectory t;
  t.bearings.push_back({});
  const auto out = calib::left_out_of(problem, {t}, SharedState()).poses;
  std::set<std::size_t> at;
  for (const calib::LeftOutPose& pose : out) {
    EXPECT_EQ(pose.reason, Rejection::kNotNeeded);
    at.insert(pose.pose);
  }
  EXPECT_THAT(at, ElementsAre(0, 4, 5));
}

TEST(LeftOut, OdometryCarriesThePosesBetweenItsEnds) {
  calib::Problem problem;
  problem.runs.resize(1);
  for (int i = 0; i < 10; ++i) problem.runs[0].poses.push_back({static_cast<double>(i), Pose()});
  Trajectory t;
  t.moving = true;
  t.odometry.resize(1);
  t.nodes.resize(2);
  t.nodes[0].time_s = 2.0;
  t.nodes[1].time_s = 6.5;
  std::set<std::size_t> at;
  for (const calib::LeftOutPose& pose : calib::left_out_of(problem, {t}, SharedState()).poses)
    at.insert(pose.pose);
  EXPECT_THAT(at, ElementsAre(0, 1, 7, 8, 9));
  t.run = 1;  // that of another recording carries none of them
  EXPECT_EQ(calib::left_out_of(problem, {t}, SharedState()).poses.size(), 10U);
}

TEST(LeftOut, AreManyBeyondAboutAThird) {
  calib::Problem problem;
  problem.runs.resize(2);
  for (MeasurementLog& run : problem.runs) run.arrivals.resize(100);
  calib::Solution solution;
  solution.left_out.resize(70, {.reason = Rejection::kLate});
  EXPECT_FALSE(calib::are_many_left_out(problem, solution));
  solution.left_out.resize(71, {.reason = Rejection::kLate});
  EXPECT_TRUE(calib::are_many_left_out(problem, solution));
  EXPECT_FALSE(calib::are_many_left_out(calib::Problem(), calib::Solution()));
}

TEST(BearingsInDoubt, NameTheBeaconMostOfWhoseLabelledBearingsDoNotFit) {
  calib::Problem problem;
  problem.site = hall_scenario().site;
  problem.runs.resize(1);
  std::vector<calib::LeftOutBearing> out;
  const auto see = [&](int beacon, int count, int wrong, Rejection why = Rejection::kLate) {
    for (int i = 0; i < count; ++i) {
      Bearing b;
      b.reflector = beacon < 0 ? BeaconId() : BeaconId(beacon);
      if (i < wrong) out.push_back({0, problem.runs[0].bearings.size(), why});
      problem.runs[0].bearings.push_back(b);
    }
  };
  see(0, 10, 5);                       // half is not most
  see(1, 10, 6, Rejection::kEarly);    // one side or the other
  see(2, 4, 4);                        // too few
  see(3, 10, 10, Rejection::kNoPose);  // no doubt of its place
  see(-1, 10, 10);                     // of nobody
  const auto words = calib::bearings_in_doubt(problem, out);
  ASSERT_EQ(words.size(), 1U);
  EXPECT_THAT(words[0], HasSubstr("beacon B1: 6 of 10 bearings do not fit its position"));
}

}  // namespace left_out_test
}  // namespace octant::test
