// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/rigid_path.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/localizers/least_squares/search_problem.h"
#include "tests/models/localizers/exact_drive.h"

namespace octant::test {
namespace rigid_path_test {

TEST(RigidPath, IsTheWayInTheFrameOfAnyOfItsStates) {
  const ExactDrive drive;
  for (const std::size_t anchor : {0U, 5U, 11U}) {
    const RigidPath path = rigid_path(drive.t, drive.t.segments[0], anchor);
    for (std::size_t k = 0; k < 12; ++k) {
      const Pose want = drive.truth[anchor].inverse() * drive.truth[k];
      EXPECT_LT((path.T_anchor_node[k].translation_m - want.translation_m).norm(), 1e-12);
      EXPECT_LT(path.T_anchor_node[k].rotation.angularDistance(want.rotation), 1e-7);
      // Steps' variances add up on either side; a heading error counts by a third of the way's square.
      const double steps = std::abs(static_cast<double>(k) - static_cast<double>(anchor));
      EXPECT_NEAR(path.drift_m[k],
                  std::sqrt(steps * 9e-4 + steps * 1e-4 * want.translation_m.squaredNorm() / 3), 1e-12);
    }
    Trajectory laid = drive.t;
    lay_rigidly(laid, drive.t.segments[0], drive.truth[anchor], path);
    for (std::size_t k = 0; k < 12; ++k) {
      EXPECT_TRUE(laid.nodes[k].placed);
      EXPECT_LT((laid.nodes[k].T_map_vehicle.translation_m - drive.truth[k].translation_m).norm(), 1e-12);
    }
  }
}

TEST(RigidPath, FollowsOdometryToEitherEndOrForSoLong) {
  ExactDrive drive;
  drive.t.nodes[5].T_map_vehicle = drive.truth[5];
  EXPECT_EQ(follow_odometry(drive.t, drive.t.segments[0], 5, true, 0.25), 8U) << "0.3 s are the first beyond";
  EXPECT_FALSE(drive.t.nodes[9].placed);
  EXPECT_EQ(follow_odometry(drive.t, drive.t.segments[0], 5, true), 11U);
  EXPECT_EQ(follow_odometry(drive.t, drive.t.segments[0], 5, false), 0U);
  for (std::size_t k = 0; k < 12; ++k)
    EXPECT_LT((drive.t.nodes[k].T_map_vehicle.translation_m - drive.truth[k].translation_m).norm(), 1e-12)
        << k;
}

TEST(ThinOut, KeepsEightyEvenlyAndTheirGroups) {
  SearchProblem problem;
  for (std::size_t i = 0; i < 333; ++i) {
    SearchRange r;
    r.beacon = BeaconId(i / 37);
    r.observation = i;
    if (i % 37 == 0) {
      problem.group_first.push_back(i);
      problem.group_bias_m.push_back(0.1 * static_cast<double>(i / 37 + 1));
    }
    problem.ranges.push_back(r);
  }
  problem.group_first.push_back(333);
  thin_out(problem);
  ASSERT_EQ(problem.ranges.size(), 80U);
  ASSERT_EQ(problem.groups(), 9U);
  for (std::size_t i = 1; i < 80; ++i) {
    const std::size_t step = problem.ranges[i].observation - problem.ranges[i - 1].observation;
    EXPECT_TRUE(step == 4 || step == 5) << i;
  }
  for (std::size_t g = 0; g < 9; ++g) {
    EXPECT_EQ(problem.ranges[problem.group_first[g]].beacon, BeaconId(g));
    EXPECT_DOUBLE_EQ(problem.group_bias_m[g], 0.1 * static_cast<double>(g + 1));
  }
  EXPECT_EQ(problem.group_first.back(), 80U);
  const std::size_t before = problem.ranges[79].observation;
  thin_out(problem);
  EXPECT_EQ(problem.ranges[79].observation, before) << "eighty are few enough";
}

}  // namespace rigid_path_test
}  // namespace octant::test
