// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Streams with gaps, disorder, kidnapping and warm air: the errors of fixes agree with their covariance.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "models/live/follower.h"
#include "tests/models/live/live_support.h"
#include "tests/models/localizers/drive_world.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {
namespace follower_integrity_test {

TEST(FollowerIntegrity, ArrivalsBehindTheOdometryOrOutOfOrderAreAllUsed) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 40, 1e-5, 1.0, 44);
  Live in_order(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), in_order.follower);
  const double in_order_m = errors_of(in_order.fixes, w.truth).rms_m;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const bool is_jitter : {false, true}) {
    std::vector<Delivery> all = deliveries(w.log);
    for (Delivery& one : all)
      if (one.arrival) one.time_s += 0.15 * (is_jitter ? uniform(random) : 1.0);
    Live live(d, with_accuracy_of(w.log));
    deliver(all, live.follower);
    const Errors errors = errors_of(live.fixes, w.truth);
    EXPECT_EQ(live.follower.counts().late + live.follower.counts().dropped, 0u);
    EXPECT_EQ(live.follower.counts().arrivals, w.log.arrivals.size());
    EXPECT_GT(errors.ok, 9 * errors_of(in_order.fixes, w.truth).ok / 10);
    EXPECT_LT(errors.rms_m, 1.5 * in_order_m) << is_jitter;
    expect_honest(errors);
  }
}

TEST(FollowerIntegrity, RowsOfOdometryMayComeOutOfOrder) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 30, 1e-5, 1.0, 44);
  Live in_order(d, with_accuracy_of(w.log)), live(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), in_order.follower);
  std::vector<Delivery> all = deliveries(w.log);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 0.15);
  for (Delivery& one : all)
    if (one.row && one.row != &w.log.odometry.front()) one.time_s += uniform(random);
  deliver(all, live.follower);
  EXPECT_LT(errors_of(live.fixes, w.truth).rms_m, 1.2 * errors_of(in_order.fixes, w.truth).rms_m);
}

TEST(FollowerIntegrity, WhatComesTooLateIsLeftOutAndCounted) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 20, 1e-5, 1.0, 44);
  Live live(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), live.follower);
  Arrival late = w.log.arrivals[w.log.arrivals.size() / 2];
  late.tof_s += 1e-6;
  EXPECT_FALSE(live.follower.hear(late));
  EXPECT_EQ(live.follower.counts().late, 1u);
}

/// Lost rows that are not included in later ones: innovation and time between rows show them.
TEST(FollowerIntegrity, AGapInTheOdometryIsNoticed) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 60, 1e-5, 1.0, 45);
  for (const double gap_s : {0.2, 1.0, 5.0})
    for (const bool arrivals_too : {false, true}) {
      MeasurementLog log = w.log;
      const auto is_lost = [&](const auto& row) { return row.time_s > 20.0 && row.time_s < 20.0 + gap_s; };
      std::erase_if(log.odometry, is_lost);
      if (arrivals_too) std::erase_if(log.arrivals, is_lost);
      Live live(d, with_accuracy_of(log));
      deliver(deliveries(log), live.follower);
      expect_honest(errors_of(live.fixes, w.truth));
      EXPECT_LT(errors_of(live.fixes, w.truth, 20.0 + gap_s).first_s, 21.0 + gap_s)
          << gap_s << " s, arrivals too: " << arrivals_too;
    }
}

/// Odometry alone leaves the pose uncertain, in the second case so much that it is searched again.
TEST(FollowerIntegrity, AfterAGapInTheArrivalsFixesHaveLevels) {
  const Deployment d = with_octagon(hall());
  for (const double share : {4.0, 7.0})
    for (const std::uint64_t seed : {49u, 50u, 51u}) {
      Drive w = drive(d, 130, 1e-5, 3.0, seed);
      w.log.odometry_accuracy.distance_sigma_m_per_sqrt_m *= 3.0;
      w.log.odometry_accuracy.heading_sigma_rad_per_sqrt_m *= share;
      std::erase_if(w.log.arrivals, [](const Arrival& a) { return a.time_s > 20.0 && a.time_s < 120.0; });
      Live live(d, with_accuracy_of(w.log));
      deliver(deliveries(w.log), live.follower);
      expect_honest(errors_of(live.fixes, w.truth));
      EXPECT_LT(errors_of(live.fixes, w.truth, 120.0).first_s, 121.0) << seed;
      for (const Fix& fix : live.fixes)
        EXPECT_TRUE(!fix.ok() || fix.protection_level_m > 0.0) << "at " << fix.time_s;
    }
}

TEST(FollowerIntegrity, RowsThatAreLostNowAndThenDoLittleHarm) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 60, 1e-5, 1.0, 46);
  Live whole(d, with_accuracy_of(w.log)), live(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), whole.follower);
  MeasurementLog log = w.log;
  std::mt19937_64 random(3);
  std::erase_if(log.odometry, [&](const OdometryStep& row) { return row.time_s > 0 && random() % 20 == 0; });
  deliver(deliveries(log), live.follower);
  expect_honest(errors_of(live.fixes, w.truth));
  EXPECT_LT(errors_of(live.fixes, w.truth).rms_m, 1.5 * errors_of(whole.fixes, w.truth).rms_m);
}

TEST(FollowerIntegrity, PosesOfOdometryLeaveNoGap) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 40, 1e-5, 1.0, 46);
  Live steps(d, with_accuracy_of(w.log)), poses(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), steps.follower);
  std::size_t next = 0;
  Pose T = Pose::planar(100.0, -30.0, 2.0);
  for (std::size_t i = 0; i < w.log.odometry.size(); ++i) {
    const OdometryStep& row = w.log.odometry[i];
    if (i > 0) T = T * row.pose();
    for (; next < w.log.arrivals.size() && w.log.arrivals[next].time_s <= row.time_s; ++next)
      poses.follower.hear(w.log.arrivals[next]);
    if (i % 3 != 1) poses.follower.move(OdometryPose{row.time_s, T, VehicleId(0)});
  }
  EXPECT_LT(errors_of(poses.fixes, w.truth).rms_m, 1.3 * errors_of(steps.fixes, w.truth).rms_m);
}

/// Lifted and set down elsewhere, which odometry does not notice.
TEST(FollowerIntegrity, AKidnappedVehicleIsFoundWithinASecond) {
  const Deployment d = with_octagon(hall());
  const Drive before = drive(d, 30, 1e-5, 1.0, 47);
  Drive after = drive(d, 60, 1e-5, 1.0, 48);
  std::erase_if(after.log.arrivals, [](const Arrival& a) { return a.time_s < 32.0; });
  std::erase_if(after.log.odometry, [](const OdometryStep& row) { return row.time_s <= 30.0; });
  Drive w = before;
  for (const Arrival& a : after.log.arrivals) {
    w.log.arrivals.push_back(a);
    w.log.arrivals.back().time_s -= 2.0;
  }
  std::vector<TimedPose> truth = before.truth;
  // The second drive begins 2 s ahead of where the first one ends.
  for (const OdometryStep& row : after.log.odometry) {
    if (row.time_s <= 32.0) continue;
    w.log.odometry.push_back(row);
    w.log.odometry.back().time_s -= 2.0;
  }
  for (const TimedPose& pose : after.truth)
    if (pose.time_s > 32.0) truth.push_back({pose.time_s - 2.0, pose.T_map_vehicle});
  Live live(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), live.follower);
  expect_honest(errors_of(live.fixes, truth));
  EXPECT_LT(errors_of(live.fixes, truth, 30.05).first_s, 31.5);
}

TEST(FollowerIntegrity, AFixOfNoArrivalIsNone) {
  const Deployment d = with_octagon(hall());
  Drive w = drive(d, 30, 1e-5, 1.0, 49);
  for (Arrival& a : w.log.arrivals)
    if (a.time_s > 20.0 && a.time_s < 20.25) a.tof_s += 5e-3;
  Live live(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), live.follower);
  int echoes = 0;
  for (const Fix& fix : live.fixes)
    if (fix.time_s > 20.0 && fix.time_s < 20.25) {
      ++echoes;
      EXPECT_EQ(integrity(fix), Integrity::kNoFix);
    }
  EXPECT_GT(echoes, 0);
  EXPECT_TRUE(live.fixes.back().ok());
}

TEST(FollowerIntegrity, StatedMotionStandsForOdometry) {
  Deployment d = with_octagon(hall());
  d.vehicles.front().motion = MotionPrior{.speed_mps = 0.7, .acceleration_mps2 = 0.3};
  Drive w = drive(d, 40, 1e-5, 1.0, 50);
  w.log.odometry.clear();
  Live live(d);
  deliver(deliveries(w.log), live.follower);
  const Errors errors = errors_of(live.fixes, w.truth);
  EXPECT_GT(errors.ok, 30 * w.log.arrivals.size() / 40 / d.receivers.size());
  EXPECT_LT(errors.rms_m, 0.05);
  expect_honest(errors);
}

/// Air of unknown temperature.
TEST(FollowerIntegrity, WarmAirIsEstimatedFromTheFirstFixOn) {
  Deployment d = with_octagon(hall());
  d.medium.model = MediumModel::kLinearTemperature;
  Deployment warm = d;
  warm.speed_offset_mps += 5.0;  // eight degrees
  const Drive w = drive(warm, 40, 1e-5, 1.0, 51);
  Live live(d, with_accuracy_of(w.log));
  deliver(deliveries(w.log), live.follower);
  const Errors errors = errors_of(live.fixes, w.truth);
  EXPECT_LT(errors.first_s, 5.0);
  EXPECT_LT(errors.rms_m, 0.03);
  expect_honest(errors);
}

TEST(FollowerIntegrity, PredictsToAnInstant) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 30, 1e-5, 1.0, 52);
  MeasurementLog log = w.log;
  std::erase_if(log.arrivals, [](const Arrival& a) { return a.time_s > 25.0; });
  Live live(d, with_accuracy_of(w.log));
  for (const Delivery& one : deliveries(log))
    if (one.row) live.follower.move(*one.row);
  Fix fix;
  live.follower.predict(VehicleId(0), 26.0, fix);
  EXPECT_FALSE(fix.ok()) << "not placed";
  Live placed(d, with_accuracy_of(w.log));
  std::size_t next = 0;
  for (const OdometryStep& row : log.odometry) {
    for (; next < log.arrivals.size() && log.arrivals[next].time_s <= row.time_s; ++next)
      placed.follower.hear(log.arrivals[next]);
    placed.follower.move(row);
  }
  placed.follower.predict(VehicleId(0), 27.0, fix);
  ASSERT_TRUE(fix.ok());
  Pose T;
  ASSERT_TRUE(interpolate_poses(w.truth, 27.0, 1.0, T));
  const double by_odometry_m = (fix.T_map_vehicle.translation_m - T.translation_m).norm();
  EXPECT_LT(by_odometry_m, 0.06);
  const double sigma_m = std::sqrt(fix.covariance(0, 0));
  placed.follower.predict(VehicleId(0), 31.0, fix);  // a second beyond the odometry
  ASSERT_TRUE(fix.ok());
  EXPECT_GT(std::sqrt(fix.covariance(0, 0)), 5 * sigma_m);
}

}  // namespace follower_integrity_test
}  // namespace octant::test
