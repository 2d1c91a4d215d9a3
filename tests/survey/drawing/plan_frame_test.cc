// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/plan_frame.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace plan_frame_test {

TEST(PlanFrame, RoundingDownGivesOneTwoOrFiveTimesAPowerOfTen) {
  for (const auto& [x, rounded] :
       {std::pair{1.0, 1.0}, {1.99, 1.0}, {2.0, 2.0}, {4.99, 2.0}, {5.0, 5.0}, {9.99, 5.0}, {10.0, 10.0}})
    for (int power = -9; power <= 9; ++power) {
      const double scale = std::pow(10.0, power);
      // Off the edges: on them a product's last digit may fall to either side.
      EXPECT_NEAR(round_down(x * scale * (1 + 1e-12)) / (rounded * scale), 1.0, 1e-12) << x << "e" << power;
    }
  Random draws(20261125);
  for (int i = 0; i < 2000; ++i) {
    const double x = draws.log_uniform(1e-12, 1e12), down = round_down(x);
    EXPECT_LE(down, x * (1 + 1e-15));
    EXPECT_GT(2.5 * down, x * (1 - 1e-15));
  }
}

bool within(const PlanFrame& frame, const Eigen::Vector2d& p) {
  return frame.x(p.x()) >= 0 && frame.x(p.x()) <= kPlanWidth_px && frame.y(p.y()) >= 0 &&
         frame.y(p.y()) <= frame.height_px;
}

PlanInput some_plan(Random& draws, double width_m, double height_m) {
  PlanInput plan;
  const auto place = [&] {
    const double x = 100 + draws.uniform(0, width_m);
    return Eigen::Vector3d(x, -50 + draws.uniform(0, height_m), 1.0);
  };
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = place();
    plan.deployment.beacons.push_back(test_beacon("B", p.x(), p.y(), 0.01, BeaconStatus::kCalibrated));
  }
  plan.tracks = {{true, {place(), place()}}};
  plan.fixes_m = {place()};
  plan.maps = {{"m", "", place().head<2>(), 0.1 * std::min(width_m, height_m), 2, {1, 2, 3, 4, 5, 6}}};
  return plan;
}

TEST(PlanFrame, HoldsAllThatIsDrawnWithRoomRoundIt) {
  Random draws(2);
  for (int i = 0; i < 200; ++i) {
    const PlanInput plan = some_plan(draws, draws.log_uniform(0.1, 1e4), draws.log_uniform(0.1, 1e4));
    const PlanFrame frame = plan_frame(plan);
    for (const auto& b : plan.deployment.beacons) EXPECT_TRUE(within(frame, b.position_m.head<2>()));
    for (const auto& p : plan.tracks[0].points_m) EXPECT_TRUE(within(frame, p.head<2>()));
    EXPECT_TRUE(within(frame, plan.fixes_m[0].head<2>()));
    const NamedMap& map = plan.maps[0];
    EXPECT_TRUE(within(frame, map.corner_m));
    EXPECT_TRUE(within(frame, map.corner_m + map.cell_m * Eigen::Vector2d(2, 3)));
    // A metre is a metre in both directions, and the plan is no ribbon.
    EXPECT_NEAR(frame.x(101) - frame.x(100), frame.y(100) - frame.y(101), 1e-9 * frame.px_per_m);
    EXPECT_LE(frame.height_px, kPlanWidth_px + 1e-6);
    EXPECT_GE(frame.height_px, 2 * kPlanMargin_px + 0.29 * (kPlanWidth_px - 2 * kPlanMargin_px));
  }
}

TEST(PlanFrame, YGoesUp) {
  const PlanFrame frame = plan_frame(full_report().plan);
  EXPECT_LT(frame.y(5.0), frame.y(4.0));
  EXPECT_GT(frame.x(5.0), frame.x(4.0));
}

TEST(PlanFrame, WhatHasNoPlaceMakesNoRoom) {
  PlanInput plan = full_report().plan;
  const PlanFrame before = plan_frame(plan);
  plan.deployment.beacons.push_back(test_beacon("far", 1e6, 1e6, 0.01, BeaconStatus::kUndetermined));
  plan.deployment.beacons.push_back(
      test_beacon("nan", std::numeric_limits<double>::quiet_NaN(), 0, 0.01, BeaconStatus::kCalibrated));
  for (std::size_t i = 3; i < 5; ++i) EXPECT_FALSE(is_drawn(plan.deployment.beacons[i]));
  plan.maps.push_back({"none", "", {1e6, 1e6}, 1.0, 0, {}});
  EXPECT_EQ(plan_frame(plan).low_m, before.low_m);
  EXPECT_EQ(plan_frame(plan).high_m, before.high_m);
}

TEST(PlanFrame, NothingAndOnePointHaveAFrame) {
  PlanInput plan;
  EXPECT_TRUE(std::isfinite(plan_frame(plan).px_per_m));
  plan.fixes_m = {{3, 4, 0}};
  const PlanFrame frame = plan_frame(plan);
  EXPECT_GT(frame.extent_m(), 0.0);
  EXPECT_TRUE(within(frame, {3, 4}));
}

TEST(PlanFrame, ThinnedPointsAreSomeOfThemFromTheFirstOn) {
  for (const std::size_t count : {0U, 1U, 1999U, 2000U, 2001U, 4000U, 123457U}) {
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < count; ++i) points.emplace_back(static_cast<double>(i), 0, 0);
    const auto few = thinned(points);
    EXPECT_LE(few.size(), kMaxMarks) << count;
    EXPECT_GE(2 * few.size() + 1, std::min(count, kMaxMarks)) << "and no fewer than that asks for";
    for (std::size_t i = 1; i < few.size(); ++i)
      EXPECT_EQ(few[i].x() - few[i - 1].x(), few[1].x() - few[0].x()) << "at even distances";
    if (count > 0) EXPECT_EQ(few[0].x(), 0.0);
  }
}

}  // namespace plan_frame_test
}  // namespace octant::survey
