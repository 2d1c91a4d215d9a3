// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/statements/hints.h"
#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace {

// Whatever is the other way round in a frame: the distances stay, turns go the other way, and what was read
// twice is what was written.
TEST(Reflections, KeepDistancesAndUndoThemselves) {
  Random draws(3);
  for (const calib::Reflection& reflection : calib::reflections()) {
    SCOPED_TRACE(reflection.words);
    for (int i = 0; i < 20; ++i) {
      const Pose a = Pose::planar(5 * draws.normal(), 5 * draws.normal(), draws.uniform(-3, 3)),
                 b = Pose::planar(5 * draws.normal(), 5 * draws.normal(), draws.uniform(-3, 3));
      const Pose A = reflection.read(a), B = reflection.read(b);
      EXPECT_NEAR((A.translation_m - B.translation_m).norm(), (a.translation_m - b.translation_m).norm(),
                  1e-12);
      EXPECT_NEAR(wrap_angle(B.heading_rad() - A.heading_rad() + b.heading_rad() - a.heading_rad()), 0.0,
                  1e-12);
      EXPECT_LT((A.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 1e-12)
          << "z stays up";
      const Pose again = reflection.read(A);
      EXPECT_LT((again.translation_m - a.translation_m).norm(), 1e-12);
      EXPECT_NEAR(wrap_angle(again.heading_rad() - a.heading_rad()), 0.0, 1e-12);
    }
  }
}

TEST(FrameBetween, IsTheOneThatTookThePointsThere) {
  Random draws(4);
  for (int trial = 0; trial < 20; ++trial) {
    Pose T = Pose::planar(5 * draws.normal(), 5 * draws.normal(), draws.uniform(-3, 3));
    T.translation_m.z() = draws.normal();
    std::vector<Eigen::Vector3d> from, to;
    for (int i = 0; i < 2 + trial % 4; ++i) {
      from.emplace_back(10 * draws.normal(), 10 * draws.normal(), draws.normal());
      to.push_back(T * from.back());
    }
    const auto found = calib::frame_between(from, to);
    ASSERT_TRUE(found);
    EXPECT_LT((found->translation_m - T.translation_m).norm(), 1e-9);
    EXPECT_NEAR(wrap_angle(found->heading_rad() - T.heading_rad()), 0.0, 1e-9);
  }
}

// Of points that are off each by itself, no turn of all brings more than a part back.
TEST(FrameBetween, IsOfLeastSquares) {
  const std::vector<Eigen::Vector3d> from = {{0, 0, 2}, {10, 0, 2}, {10, 6, 2}, {0, 6, 3}};
  std::vector<Eigen::Vector3d> to = from;
  to[1].y() += 0.3;
  to[2].z() += 0.2;
  const auto found = calib::frame_between(from, to);
  ASSERT_TRUE(found);
  const auto squares = [&](const Pose& T) {
    double sum = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) sum += (to[i] - T * from[i]).squaredNorm();
    return sum;
  };
  for (const double step : {-1e-3, 1e-3}) {
    EXPECT_LT(squares(*found), squares(Pose::planar(0, 0, step) * *found));
    for (int i = 0; i < 3; ++i) {
      Pose other = *found;
      other.translation_m[i] += step;
      EXPECT_LT(squares(*found), squares(other));
    }
  }
}

TEST(FrameBetween, NeedsPointsThatTellATurn) {
  EXPECT_FALSE(calib::frame_between({}, {}));
  EXPECT_FALSE(calib::frame_between({{1, 2, 3}}, {{1, 2, 3}}));
  EXPECT_FALSE(calib::frame_between({{1, 2, 3}, {1, 2, 4}}, {{1, 2, 3}, {1, 2, 4}})) << "one above the other";
}

/// Stops with measured poses in a frame that is turned and shifted against the control points'.
World surveyed_in(const Pose& T_frame_map) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  s.log_poses = true;
  World world = must(simulate(s, 3));
  for (TimedPose& pose : world.run.poses) pose.T_map_vehicle = T_frame_map * pose.T_map_vehicle;
  return world;
}

std::vector<Contradiction> explained(const World& world) {
  const calib::Problem problem = problem_of(world);
  calib::Solution solution = calib::solve(problem);
  calib::explain(problem, problem, solution, {});
  return solution.contradictions;
}

// All control points were blamed, one by one.
TEST(FrameOfPoses, IsNamedInPlaceOfTheControlPoints) {
  EXPECT_THAT(explained(surveyed_in(Pose{})), ::testing::IsEmpty());
  const auto found = explained(surveyed_in(Pose::planar(0.2, -0.1, -0.03)));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kPoses);
  EXPECT_EQ(found[0].stated, "in the frame of the control points");
  EXPECT_THAT(found[0].found, ::testing::HasSubstr("turned by 1.7"));
}

// A point that is elsewhere is no frame.
TEST(FrameOfPoses, IsRightWhereOneControlPointIsWrong) {
  World world = surveyed_in(Pose{});
  for (SiteBeacon& b : world.site.beacons)
    if (b.is_control_point()) {
      *b.position_m[0] += 0.3;
      break;
    }
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kControlPoint);
}

}  // namespace
}  // namespace octant::test
