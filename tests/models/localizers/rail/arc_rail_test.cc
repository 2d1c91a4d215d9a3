// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/arc_rail.h"

#include <cmath>

#include <gtest/gtest.h>

namespace octant {
namespace {

using Point = Eigen::Vector2d;

TEST(ArcRail, AnglesAreThoseOfTheTriangle) {
  const ArcRail arc{.radius_m = 4.0, .centre_m = 6.0};
  for (double alpha = 0.05; alpha < 3.1; alpha += 0.1) {
    // Figure 3: beacon at the origin, centre at (0, -C), robot alpha to the left of the line between them.
    const Point robot = Point(0, -arc.centre_m) + arc.radius_m * Point(-std::sin(alpha), std::cos(alpha));
    const auto angles = arc_angles(arc, robot.norm());
    ASSERT_TRUE(angles);
    EXPECT_NEAR(angles->alpha_rad, alpha, 1e-12);
    EXPECT_NEAR(angles->phi_rad, std::atan2(robot.y(), -robot.x()), 1e-12);
    EXPECT_LT((arc_position_m({robot.norm(), angles->phi_rad}) - robot).norm(), 1e-11);  // eq. 8
  }
  EXPECT_FALSE(arc_angles(arc, 1.9)) << "nearer than the arc comes";
  EXPECT_FALSE(arc_angles({.radius_m = 4.0, .centre_m = 0.0}, 4.0));
}

TEST(ArcRail, AStepIsRightToFirstOrder) {
  const ArcRail arc{.radius_m = 4.0, .centre_m = 6.0};
  const auto at = [&](double alpha) { return Point(-4.0 * std::sin(alpha), 4.0 * std::cos(alpha) - 6.0); };
  const double alpha = 0.9;
  double before_m = 0.0;
  for (double step = 0.08; step > 0.001; step /= 2) {
    const auto next = arc_step(arc, {at(alpha).norm(), arc_angles(arc, at(alpha).norm())->phi_rad},
                               at(alpha - step).norm());
    ASSERT_TRUE(next);
    const double error_m = (arc_position_m(*next) - at(alpha - step)).norm();
    // Half the step, a quarter of the error; 10 % for the third order.
    if (before_m > 0) {
      EXPECT_NEAR(error_m / before_m, 0.25, 0.025);
    }
    before_m = error_m;
  }
  EXPECT_FALSE(arc_step(arc, {2.0, M_PI / 2}, 2.01)) << "abreast of the beacon a range does not tell the way";
}

}  // namespace
}  // namespace octant
