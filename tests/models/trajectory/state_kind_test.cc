// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/state_kind.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/trajectory/make_trajectory.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace state_kind_test {

TEST(StateKind, IsByWhatTheRunHas) {
  TrajectoryModel model;
  model.motion_priors.resize(2);
  model.motion_priors[1] = MotionPrior{};
  MeasurementLog log;
  const auto kind = [&](int vehicle = 0) { return state_kind(log, VehicleId(vehicle), model); };
  EXPECT_EQ(kind(), StateKind::kMoments);
  EXPECT_EQ(kind(1), StateKind::kMotion);
  log.poses.resize(1);
  EXPECT_EQ(kind(1), StateKind::kMoments) << "measured poses carry what a prior would";
  log.odometry = {{.time_s = 0.0, .vehicle = VehicleId(0)}};
  EXPECT_EQ(kind(), StateKind::kMoments) << "one row is no step";
  log.odometry.push_back({.time_s = 1.0, .vehicle = VehicleId(0)});
  EXPECT_EQ(kind(), StateKind::kDrive);
  EXPECT_EQ(kind(1), StateKind::kMoments) << "the other vehicle's odometry";
  log.has_epochs = true;
  EXPECT_EQ(kind(), StateKind::kChainedStops);
  EXPECT_EQ(kind(1), StateKind::kStops);
  log = {};
  model.motion = Motion::kSpatial;
  EXPECT_EQ(kind(1), StateKind::kMoments) << "priors are of the plane";
  model.motion = Motion::kPlanar;
  model.timing.clock = Clock::kCycleOffset;
  EXPECT_EQ(kind(1), StateKind::kMoments) << "and of one clock";
}

// Arrivals farther apart than the tie never share a segment, and so may be calibrated apart.
TEST(StateKind, NoSegmentOutlastsItsTie) {
  World world = must(simulate(drive_scenario(60.0), 3));
  world.run.odometry.clear();
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return std::fmod(a.time_s, 30.0) > 15.0; });
  for (const bool prior : {false, true}) {
    TrajectoryModel model;
    model.medium = world.site.medium;
    model.noise = world.site.noise;
    model.motion_priors = {prior ? std::optional<MotionPrior>(MotionPrior{}) : std::nullopt};
    const StateKind kind = state_kind(world.run, VehicleId(0), model);
    ASSERT_EQ(kind, prior ? StateKind::kMotion : StateKind::kMoments);
    const Trajectory t = make_trajectory(world.run, 0, VehicleId(0), model);
    ASSERT_GT(t.segments.size(), 1U);
    for (const Segment& s : t.segments)
      for (std::size_t i = s.first_arrival + 1; i < s.last_arrival; ++i)
        EXPECT_LE(t.arrivals[i].time_s - t.arrivals[i - 1].time_s, longest_tie_s(kind));
  }
  EXPECT_EQ(longest_tie_s(StateKind::kChainedStops), INFINITY);
}

}  // namespace state_kind_test
}  // namespace octant::test
