// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/stretches.h"

#include <gtest/gtest.h>

namespace octant {
namespace stretches_test {

/// A drive with an arrival between neighbours, an odometry row too, and a pose now and then.
Trajectory drive_of(std::size_t nodes) {
  Trajectory t;
  t.moving = true;
  t.nodes.resize(nodes);
  for (std::size_t k = 0; k < nodes; ++k) t.nodes[k].time_s = static_cast<double>(k);
  for (std::size_t k = 0; k + 1 < nodes; ++k) {
    ArrivalObservation a;
    a.node = static_cast<std::uint32_t>(k);
    a.alpha = 0.5;
    a.arrival = static_cast<std::uint32_t>(k);
    t.arrivals.push_back(a);
    t.odometry.push_back({k, Pose(), 0.01, 0.01});
    if (k % 100 == 0) t.poses.push_back({k, 0.5, Pose(), 0.01, 0.01, 0.01});
  }
  t.segments.push_back({0, nodes, 0, t.arrivals.size(), 0, 0, 0, t.poses.size(), 0, t.odometry.size()});
  return t;
}

/// Every observation belongs to states of its segment, and was made of the same states before.
void expect_whole(const Trajectory& few, const Trajectory& all) {
  std::size_t nodes = 0;
  for (const Segment& s : few.segments) {
    EXPECT_EQ(s.first_node, nodes);
    nodes = s.last_node;
    EXPECT_EQ(s.last_odometry - s.first_odometry, s.last_node - s.first_node - 1);
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
      const ArrivalObservation& a = few.arrivals[i];
      ASSERT_GE(a.node, s.first_node);
      ASSERT_LT(a.node + 1, s.last_node);
      EXPECT_EQ(few.nodes[a.node].time_s, all.nodes[all.arrivals[a.arrival].node].time_s);
    }
    for (std::size_t i = s.first_pose; i < s.last_pose; ++i) ASSERT_LT(few.poses[i].node + 1, s.last_node);
  }
  EXPECT_EQ(nodes, few.nodes.size());
}

TEST(Stretches, OfALongDriveStandForSegments) {
  const Trajectory all = drive_of(kLongChain + 1000);
  const Trajectory half = some_segments(all, 2);
  EXPECT_EQ(half.segments.size(), (kLongChain + 1000 + kStretchNodes - 1) / kStretchNodes / 2);
  expect_whole(half, all);
}

TEST(Stretches, AShortDriveIsNotCut) {
  const Trajectory all = drive_of(kLongChain);
  const Trajectory half = some_segments(all, 2);
  EXPECT_EQ(half.segments.size(), 1U);
  EXPECT_EQ(half.arrivals.size(), all.arrivals.size());
}

TEST(Stretches, SpreadEvenly) {
  const Trajectory all = drive_of(1000);
  const std::vector<Segment> stretches = spread_stretches(all, all.segments[0], 4, 30);
  ASSERT_EQ(stretches.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(stretches[i].first_node, 250 * i);
    EXPECT_EQ(stretches[i].last_node, 250 * i + 30);
  }
  expect_whole(pick_segments(all, stretches), all);
}

}  // namespace stretches_test
}  // namespace octant
