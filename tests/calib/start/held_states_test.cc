// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/held_states.h"

#include <gtest/gtest.h>

#include <cmath>

namespace octant::calib {
namespace held_states_test {

/// Two segments of four states along x; one has no position yet.
Trajectory path(Motion motion, bool moving) {
  Trajectory t;
  t.motion = motion;
  t.moving = moving;
  for (int k = 0; k < 8; ++k) {
    Node node;
    node.T_map_vehicle.translation_m = {0.5 * k, 1.0, 0.25 * k};
    node.placed = k != 5;
    t.nodes.push_back(node);
  }
  t.segments.resize(2);
  t.segments[0].last_node = t.segments[1].first_node = 4;
  t.segments[1].last_node = 8;
  if (moving) t.odometry.resize(6);
  return t;
}

void expect_ranges_of_segments(const Trajectory& t) {
  ASSERT_EQ(t.segments[0].first_pose, 0U);
  ASSERT_EQ(t.segments[0].last_pose, t.segments[1].first_pose);
  ASSERT_EQ(t.segments[1].last_pose, t.poses.size());
  for (const Segment& s : t.segments)
    for (std::size_t i = s.first_pose; i < s.last_pose; ++i) {
      EXPECT_GE(t.poses[i].node, s.first_node);
      EXPECT_LT(t.poses[i].node, s.last_node);
      EXPECT_EQ(t.poses[i].T_map_vehicle.translation_m, t.nodes[t.poses[i].node].T_map_vehicle.translation_m);
    }
}

TEST(HeldStates, HoldEachPlacedStateOfAPathWhereItIs) {
  std::vector<Trajectory> all = {path(Motion::kSpatial, true)};
  {
    const HeldStates held = HeldStates::paths(all, 0.02, 0.03);
    ASSERT_EQ(all[0].poses.size(), 7U) << "all but the one without a place";
    expect_ranges_of_segments(all[0]);
    for (const PoseObservation& p : all[0].poses) {
      EXPECT_NE(p.node, 5U);
      EXPECT_EQ(p.position_sigma_m, 0.02);
      EXPECT_EQ(p.heading_sigma_rad, 0.03);
      EXPECT_EQ(p.attitude_sigma_rad, 0.03);
    }
  }
  EXPECT_TRUE(all[0].poses.empty());
  EXPECT_EQ(all[0].segments[1].last_pose, 0U);
}

TEST(HeldStates, PathsAreThoseOfDrivesInSpaceByOdometryAlone) {
  EXPECT_TRUE(can_be_held(path(Motion::kSpatial, true)));
  EXPECT_FALSE(can_be_held(path(Motion::kPlanar, true)));
  EXPECT_FALSE(can_be_held(path(Motion::kSpatial, false)));
  Trajectory measured = path(Motion::kSpatial, true);
  measured.poses.resize(1);
  EXPECT_FALSE(can_be_held(measured));
  Trajectory by_motion = path(Motion::kSpatial, true);
  by_motion.motion_prior = MotionPrior{};
  EXPECT_FALSE(can_be_held(by_motion));
  std::vector<Trajectory> others = {measured, path(Motion::kPlanar, true)};
  const HeldStates held = HeldStates::paths(others, 0.1, 0.1);
  EXPECT_EQ(others[0].poses.size(), 1U);
  EXPECT_TRUE(others[1].poses.empty());
}

TEST(HeldStates, HoldHeadingsOfStopsInThePlaneAlone) {
  std::vector<Trajectory> all = {path(Motion::kPlanar, false), path(Motion::kPlanar, true),
                                 path(Motion::kSpatial, false)};
  // The second segment has a measured pose, which stays and is enough.
  all[0].poses.push_back({.node = 6, .T_map_vehicle = {}, .position_sigma_m = 0.5});
  all[0].segments[1].last_pose = 1;
  {
    const HeldStates held = HeldStates::headings(&all);
    ASSERT_EQ(all[0].poses.size(), 5U);
    EXPECT_EQ(all[0].segments[0].last_pose, 4U);
    EXPECT_EQ(all[0].segments[1].first_pose, 4U);
    EXPECT_EQ(all[0].poses[4].position_sigma_m, 0.5);
    for (int i = 0; i < 4; ++i) {
      EXPECT_TRUE(std::isinf(all[0].poses[static_cast<std::size_t>(i)].position_sigma_m));
      EXPECT_LT(all[0].poses[static_cast<std::size_t>(i)].heading_sigma_rad, 0.5);
    }
    EXPECT_TRUE(all[1].poses.empty());
    EXPECT_TRUE(all[2].poses.empty());
  }
  EXPECT_EQ(all[0].poses.size(), 1U);
  EXPECT_EQ(all[0].segments[1].first_pose, 0U);
  const HeldStates nothing = HeldStates::headings(nullptr);
}

}  // namespace held_states_test
}  // namespace octant::calib
