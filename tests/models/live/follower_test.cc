// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/follower.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/models/live/live_support.h"
#include "tests/models/localizers/drive_world.h"
#include "tests/models/localizers/hall.h"
#include "tests/support/worlds.h"

namespace octant {
namespace follower_test {

using test::Drive;
using test::drive;
using test::hall;
using test::Live;
using test::with_octagon;
using test::with_receiver;

/// Ten stops, an epoch each.
MeasurementLog stops(const Deployment& d) {
  std::mt19937_64 random(7);
  MeasurementLog log;
  log.has_epochs = true;
  for (int k = 0; k < 10; ++k)
    for (const Arrival& a :
         test::hear(d, Pose::planar(4 + k, 3 + 0.5 * k, 0.3 * k), {.noise_s = 1e-5}, random, k, 10.0 * k))
      log.arrivals.push_back(a);
  return log;
}

void expect_same(const std::vector<Fix>& live, const std::vector<Fix>& after) {
  ASSERT_EQ(live.size(), after.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    EXPECT_EQ(live[i].status, after[i].status) << i;
    EXPECT_EQ(live[i].time_s, after[i].time_s) << i;
    EXPECT_EQ(live[i].rejections, after[i].rejections) << i;
    EXPECT_EQ(live[i].protection_level_m, after[i].protection_level_m) << i;
    if (live[i].ok()) {
      EXPECT_TRUE(live[i].T_map_vehicle.translation_m == after[i].T_map_vehicle.translation_m) << i;
    }
  }
}

TEST(Follower, GivesEveryStop) {
  const Deployment d = with_octagon(hall());
  const MeasurementLog log = stops(d);
  Live live(d);
  for (const Arrival& a : log.arrivals) live.follower.hear(a);
  EXPECT_EQ(live.fixes.size(), 9u);
  live.follower.flush();
  live.follower.flush();  // nothing is open any more
  expect_same(live.fixes, LeastSquaresLocalizer(d).locate(log));
  EXPECT_EQ(live.follower.counts().fixes, 10u);
  EXPECT_EQ(live.follower.counts().used + live.follower.counts().rejected, log.arrivals.size());
}

/// A drive as a robot gets it: each row of odometry after the arrivals that it covers.
void feed(Follower& follower, const MeasurementLog& log) {
  std::size_t next = 0;
  for (const OdometryStep& step : log.odometry) {
    while (next < log.arrivals.size() && log.arrivals[next].time_s <= step.time_s)
      follower.hear(log.arrivals[next++]);
    follower.move(step);
  }
}

/// Result of the offline tracker for a recording if it uses past data only.
TrackerOptions causal() {
  TrackerOptions options = live_tracking();
  options.smooth = false;
  return options;
}

TEST(Follower, OdometryMakesATrack) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 40, 1e-5, 1.0, 41);
  FollowOptions options;
  options.odometry = w.log.odometry_accuracy;
  Live live(d, options);
  feed(live.follower, w.log);
  expect_same(live.fixes, track(w.log, d, causal()));
  EXPECT_EQ(integrity(live.fixes.back()), Integrity::kOk) << "its error is bounded";
  EXPECT_GT(live.follower.counts().fixes, 300u);
  EXPECT_EQ(live.follower.counts().dropped, 0u);
}

/// Receivers so close to each other that the first arrivals leave the attitude open.
TEST(Follower, AStartInSpaceWaitsForTheAttitude) {
  Scenario s = test::drive_scenario(20.0);
  s.site.motion = Motion::kSpatial;
  s.log_odometry = true;
  for (SiteReceiver& r : s.site.receivers) r.position_m *= 0.06;
  for (const std::uint64_t seed : {5, 6, 7}) {
    const World world = test::must(simulate(s, seed));
    FollowOptions options;
    options.odometry = world.heldout.odometry_accuracy;
    Live live(world.truth, options);
    feed(live.follower, world.heldout);
    const auto first = std::ranges::find_if(live.fixes, &Fix::ok);
    ASSERT_NE(first, live.fixes.end());
    EXPECT_LT(std::sqrt(first->covariance.diagonal().tail<3>().maxCoeff()), 0.6) << seed;
  }
}

TEST(Follower, OdometryInSpaceMakesATrackWithAttitude) {
  Scenario s = test::drive_scenario(30.0);
  s.site.motion = Motion::kSpatial;
  s.log_odometry = true;
  const World world = test::must(simulate(s, 5));
  FollowOptions options;
  options.odometry = world.heldout.odometry_accuracy;
  Live live(world.truth, options);
  feed(live.follower, world.heldout);
  expect_same(live.fixes, track(world.heldout, world.truth, causal()));
  ASSERT_FALSE(live.fixes.empty());
  ASSERT_TRUE(live.fixes.back().ok());
  Pose truth;
  ASSERT_TRUE(interpolate_poses(world.heldout.truth, live.fixes.back().time_s, 1.0, truth));
  EXPECT_LT(truth.rotation.angularDistance(live.fixes.back().T_map_vehicle.rotation), 0.1);
  EXPECT_EQ(live.fixes.back().covariance.rows(), 6);
  EXPECT_EQ(integrity(live.fixes.back()), Integrity::kOk) << "its error is bounded";
}

TEST(Follower, ADeploymentThatTakesOverGoesOnFromThePlace) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 40, 1e-5, 1.0, 42);
  MeasurementLog first = w.log, second = w.log;
  first.odometry.resize(400);
  second.odometry.erase(second.odometry.begin(), second.odometry.begin() + 400);
  const auto before = [&](const Arrival& a) { return a.time_s <= first.odometry.back().time_s; };
  std::erase_if(first.arrivals, std::not_fn(before));
  std::erase_if(second.arrivals, before);
  Live live(d), next(d);
  feed(live.follower, first);
  ASSERT_TRUE(live.fixes.back().ok());
  next.follower.carry_on(live.follower);
  feed(next.follower, second);
  for (const Fix& fix : next.fixes) EXPECT_TRUE(fix.ok());
  ASSERT_GT(next.fixes.size(), 100u);
}

TEST(Follower, AClockThatIsSetBackIsFollowedAgain) {
  const Deployment d = with_octagon(hall());
  const MeasurementLog log = stops(d);
  Live live(d);
  for (const Arrival& a : log.arrivals) live.follower.hear(a);
  for (Arrival a : log.arrivals) {
    a.time_s -= 1e6;
    live.follower.hear(a);
  }
  live.follower.flush();
  const FollowCounts& counts = live.follower.counts();
  EXPECT_EQ(counts.restarts, 1u);
  EXPECT_EQ(counts.late, 19u) << "until it was believed";
  EXPECT_EQ(counts.arrivals + counts.late, 2 * log.arrivals.size());
  ASSERT_GE(live.fixes.size(), 17u);
  EXPECT_TRUE(live.fixes.back().ok());
  EXPECT_LT(live.fixes.back().time_s, 0.0);
}

TEST(Follower, OneRowFromTheFarFutureIsNoEnd) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 40, 1e-5, 1.0, 43);
  Live live(d);
  feed(live.follower, w.log);
  const std::size_t before = live.fixes.size();
  MeasurementLog next = w.log;
  for (Arrival& a : next.arrivals) a.time_s += 100;
  for (OdometryStep& step : next.odometry) step.time_s += 100;
  Arrival broken = next.arrivals.front();
  broken.time_s = 1e18;
  live.follower.hear(broken);
  feed(live.follower, next);
  EXPECT_GE(live.follower.counts().restarts, 1u);
  EXPECT_GT(live.fixes.size(), before + 200);
  EXPECT_TRUE(live.fixes.back().ok());
}

TEST(Follower, AStepOfImpossibleLengthIsRefused) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 40, 1e-5, 1.0, 43);
  for (const double length_m : {1e12, -1e160, 1e308}) {
    MeasurementLog log = w.log;
    log.odometry[log.odometry.size() / 2].dx_m = length_m;
    Live live(d);
    feed(live.follower, log);
    EXPECT_EQ(live.follower.counts().refused, 1u) << length_m;
    EXPECT_TRUE(live.fixes.back().ok()) << length_m;
    for (const Fix& fix : live.fixes) {
      if (!fix.ok()) continue;
      EXPECT_TRUE(fix.covariance.allFinite()) << length_m;
      EXPECT_LT(fix.T_map_vehicle.translation_m.norm(), 100.0) << length_m;
    }
  }
}

/// A datagram that comes twice is one measurement, as a row that a file has twice is.
TEST(Follower, ARepeatedArrivalIsTakenOnce) {
  const Deployment d = with_octagon(hall());
  const MeasurementLog log = stops(d);
  Live once(d), twice(d);
  for (const Arrival& a : log.arrivals) {
    EXPECT_TRUE(once.follower.hear(a));
    EXPECT_TRUE(twice.follower.hear(a));
    EXPECT_FALSE(twice.follower.hear(a));
  }
  once.follower.flush();
  twice.follower.flush();
  expect_same(twice.fixes, once.fixes);
  EXPECT_EQ(twice.follower.counts().refused, log.arrivals.size());
  Arrival other = log.arrivals.back();
  other.tof_s += 1e-6;
  EXPECT_FALSE(twice.follower.hear(log.arrivals.back())) << "though its pose is fixed";
  EXPECT_TRUE(twice.follower.hear(other)) << "another measurement";
}

/// A callback that feeds its data back would fix one pose repeatedly.
TEST(Follower, NothingIsTakenWithinASink) {
  const Deployment d = with_octagon(hall());
  const MeasurementLog log = stops(d);
  Follower follower(d);
  int fixes = 0;
  follower.on_fix = [&](const Fix&) {
    ++fixes;
    EXPECT_FALSE(follower.hear(log.arrivals.back()));
    EXPECT_FALSE(follower.move({1e3, 0, 0, 0, VehicleId(0)}));
    follower.flush();
    follower.flush_pings();
  };
  for (const Arrival& a : log.arrivals) EXPECT_TRUE(follower.hear(a));
  follower.flush();
  EXPECT_EQ(fixes, 10);
  EXPECT_EQ(follower.counts().refused, 20u);
}

TEST(Follower, SomeRowsOutOfOrderAreNoClock) {
  const Deployment d = with_octagon(hall());
  const MeasurementLog log = stops(d);
  Live live(d);
  for (const Arrival& a : log.arrivals) live.follower.hear(a);
  for (std::size_t k = 100; k-- > 0;) {  // each behind the one before: disorder, no other time
    Arrival a = log.arrivals.front();
    a.time_s = static_cast<double>(k) * 1e-3 - 1;
    live.follower.hear(a);
  }
  EXPECT_EQ(live.follower.counts().restarts, 0u);
  EXPECT_EQ(live.follower.counts().late, 100u);
}

TEST(Follower, MemoryIsBounded) {
  const Deployment d = with_octagon(hall());
  FollowOptions options;
  options.most_waiting = 50;
  Live live(d, options);
  live.follower.move({0.0, 0, 0, 0, VehicleId(0)});
  Arrival a;
  a.beacon = BeaconId(0);
  a.receiver = ReceiverId(0);
  a.vehicle = VehicleId(0);
  for (int i = 0; i < 1000; ++i) {
    a.time_s = 1.0 + 1e-4 * i;  // faster than odometry is waited for
    live.follower.hear(a);
  }
  EXPECT_EQ(live.follower.counts().dropped, 950u);
  live.follower.move({2000.0, 0, 0, 0, VehicleId(0)});
  EXPECT_EQ(live.fixes.size(), 50u);

  Live open(d, options);
  a.time_s = 1.0;
  a.epoch = 3;
  for (int i = 0; i < 1000; ++i) {  // an epoch that never ends
    a.tof_s = 1e-2 + 1e-6 * i;
    open.follower.hear(a);
  }
  EXPECT_EQ(open.fixes.size(), 19u);
}

TEST(Follower, AMomentOfQuietEndsNoStop) {
  const Deployment d = with_octagon(hall());
  MeasurementLog log = stops(d);
  Live live(d);
  for (std::size_t i = 0; i < 5; ++i) live.follower.hear(log.arrivals[i]);
  live.follower.flush_pings();
  EXPECT_TRUE(live.fixes.empty());
  Live moving(d);
  for (std::size_t i = 0; i < 5; ++i) {
    log.arrivals[i].epoch = kNoEpoch;
    moving.follower.hear(log.arrivals[i]);
  }
  moving.follower.flush_pings();
  EXPECT_FALSE(moving.fixes.empty());
}

TEST(Follower, WatchesABeaconThatWasMoved) {
  const Deployment d = with_octagon(hall());
  Deployment moved = d;
  moved.beacons[4].position_m.x() += 0.15;
  std::mt19937_64 random(7);
  FollowOptions options;
  options.watch = true;
  Live live(d, options);
  for (int k = 0; k < 400 && live.alarms.empty(); ++k) {
    const Pose T = Pose::planar(4 + 0.03 * k, 6 + 3 * std::sin(0.1 * k), 0.2 * k);
    for (const Arrival& a : test::hear(moved, T, {.noise_s = 1e-5}, random, k, k)) live.follower.hear(a);
  }
  ASSERT_EQ(live.alarms.size(), 1u);
  EXPECT_EQ(live.alarms[0].beacon, BeaconId(4));
}

TEST(Follower, SaysWhatItCannotFollow) {
  Deployment d = with_octagon(hall());
  EXPECT_TRUE(follow_fits(d, Method::kAuto));
  EXPECT_TRUE(follow_fits(d, Method::kTracker));
  EXPECT_FALSE(follow_fits(d, Method::kReflectors));
  EXPECT_FALSE(follow_fits(d, Method::kLineMap));
  EXPECT_FALSE(follow_fits(d, Method::kRail));
  d.timing.clock = Clock::kCycleOffset;
  EXPECT_FALSE(follow_fits(d, Method::kTracker));
}

/// Rows of any kind, in any order, with any ids and numbers.
RC_GTEST_PROP(Follower, TakesAnything, ()) {
  const Deployment d = with_receiver(hall(), {0.1, 0.0, 0.3});
  FollowOptions options;
  options.most_waiting = 20;
  options.watch = true;
  Live live(d, options);
  const auto number = rc::gen::weightedOneOf<double>(
      {{8, rc::gen::map(rc::gen::inRange(0, 2000), [](int i) { return 1e-2 * i; })},
       {1, rc::gen::element(std::nan(""), -1e300, 1e300, std::numeric_limits<double>::infinity())}});
  const auto id = rc::gen::weightedOneOf<std::int32_t>(
      {{6, rc::gen::inRange<std::int32_t>(0, 1)}, {1, rc::gen::arbitrary<std::int32_t>()}});
  const int rows = *rc::gen::inRange(0, 60);
  for (int i = 0; i < rows; ++i) {
    switch (*rc::gen::inRange(0, 8)) {
      case 0: live.follower.flush(); break;
      case 1:
      case 2: live.follower.move({*number, 1e-3 * *number, 0.0, 1e-4 * *number, VehicleId(*id)}); break;
      default: {
        Arrival a;
        a.time_s = *number;
        a.tof_s = 1e-3 * *number;
        a.beacon = BeaconId(*rc::gen::inRange<std::int32_t>(-1, 10));
        a.receiver = ReceiverId(*id);
        a.vehicle = VehicleId(*id);
        a.epoch = *rc::gen::element(std::int64_t{kNoEpoch}, std::int64_t{0}, std::int64_t{1});
        live.follower.hear(a);
      }
    }
  }
  live.follower.flush();
  for (const Fix& fix : live.fixes)
    RC_ASSERT(!fix.ok() || (fix.T_map_vehicle.translation_m.allFinite() && fix.covariance.allFinite()));
}

}  // namespace follower_test
}  // namespace octant
