// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_frames.h"

#include <gtest/gtest.h>

#include "models/simulator/random.h"

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

}  // namespace
}  // namespace octant::test
