// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/odometry_queue.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace octant {
namespace odometry_queue_test {

constexpr double kRow_s = 0.1, kSpeed_mps = 0.5;

OdometryStep row(double time_s, double dx_m = kRow_s * kSpeed_mps) {
  return {time_s, dx_m, 0.0, 0.0, VehicleId(0)};
}

OdometryQueue queue() { return {OdometryAccuracy{}, Motion::kPlanar, std::nullopt}; }

/// Output of a queue.
struct Way {
  double moved_m = 0.0, coasted_s = 0.0;
  void advance(OdometryQueue& queue, double time_s) {
    queue.advance_to(
        time_s, [&](const MotionPart& part) { moved_m += part.observation.T_before_after.translation_m.x(); },
        [&](double span_s, double) { coasted_s += span_s; });
  }
};

TEST(OdometryQueue, GivesRowsInTheOrderOfTimeAndPartsOfThem) {
  OdometryQueue q = queue();
  for (const int k : {0, 3, 1, 2, 4}) EXPECT_TRUE(q.insert(row(kRow_s * k)));
  EXPECT_FALSE(q.insert(row(kRow_s * 3))) << "there already";
  Way way;
  way.advance(q, 0.25);
  EXPECT_NEAR(way.moved_m, 0.25 * kSpeed_mps, 1e-12);
  way.advance(q, 0.4);
  EXPECT_NEAR(way.moved_m, 0.4 * kSpeed_mps, 1e-12);
  EXPECT_EQ(way.coasted_s, 0.0);
  EXPECT_FALSE(q.insert(row(0.35))) << "past";
}

/// Twenty rows, then this number of missing ones.
OdometryQueue with_gap(int missing) {
  OdometryQueue q = queue();
  for (int k = 0; k <= 20; ++k) EXPECT_TRUE(q.insert(row(kRow_s * k)));
  Way way;
  way.advance(q, 2.0);
  EXPECT_NEAR(q.velocity()[0], kSpeed_mps, 1e-3);
  EXPECT_TRUE(q.insert(row(2.0 + kRow_s * (missing + 1))));
  return q;
}

TEST(OdometryQueue, ARowThatIsMissingIsAGap) {
  OdometryQueue q = with_gap(2);
  EXPECT_FALSE(q.covers(2.05));
  Way way;
  way.advance(q, 2.3);
  EXPECT_NEAR(way.coasted_s, 0.2, 1e-9);
  EXPECT_NEAR(way.moved_m, kRow_s * kSpeed_mps, 1e-9);
}

TEST(OdometryQueue, ARowThatComesAfterAllFillsIt) {
  OdometryQueue q = with_gap(1);
  EXPECT_FALSE(q.covers(2.15));
  EXPECT_TRUE(q.insert(row(2.1)));
  EXPECT_TRUE(q.covers(2.15));
}

TEST(OdometryQueue, ARowThatSumsUpWhatWasNotSentLeavesNone) {
  OdometryQueue q = queue();
  for (int k = 0; k <= 20; ++k) EXPECT_TRUE(q.insert(row(kRow_s * k)));
  Way way;
  way.advance(q, 2.0);
  EXPECT_TRUE(q.insert(row(2.3, 0.3 * kSpeed_mps)));
  EXPECT_TRUE(q.covers(2.3));
}

TEST(OdometryQueue, PosesLeaveNoGap) {
  OdometryQueue q = queue();
  for (const double time_s : {0.0, 0.1, 0.2, 0.3, 0.9})
    EXPECT_TRUE(q.insert(time_s, Pose::planar(5.0 + kSpeed_mps * time_s, 7.0, 0.0)));
  EXPECT_TRUE(q.covers(0.9));
  Way way;
  way.advance(q, 0.9);
  EXPECT_NEAR(way.moved_m, 0.9 * kSpeed_mps, 1e-12);
}

TEST(OdometryQueue, WithoutOdometryAllIsCoasted) {
  OdometryQueue q = queue();
  q.begin(10.0);
  Way way;
  way.advance(q, 12.0);
  EXPECT_NEAR(way.coasted_s, 2.0, 1e-9);
  EXPECT_FALSE(q.has_rows());
}

TEST(OdometryQueue, GoesBackAndForthAlongWhatItRemembers) {
  OdometryQueue q = queue();
  for (int k = 0; k <= 5; ++k) EXPECT_TRUE(q.insert(row(kRow_s * k)));
  q.advance_to(
      0.5, [&](const MotionPart& part) { q.remember(part.observation, part.span_s); }, [](double, double) {});
  double back_m = 0.0, forward_m = 0.0;
  q.back_to(0.22, [&](const OdometryObservation& o) { back_m += o.T_before_after.translation_m.x(); });
  q.forward_from(0.22,
                 [&](const OdometryObservation& o) { forward_m += o.T_before_after.translation_m.x(); });
  EXPECT_NEAR(back_m, -0.28 * kSpeed_mps, 1e-9);
  EXPECT_NEAR(forward_m, 0.28 * kSpeed_mps, 1e-9);
}

}  // namespace odometry_queue_test
}  // namespace octant
