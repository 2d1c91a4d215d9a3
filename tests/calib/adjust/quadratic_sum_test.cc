// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/quadratic_sum.h"

#include <gtest/gtest.h>

namespace octant::test {
namespace {

// What is left of a log when its arrivals are gone: a parabola in all parameters.
TEST(QuadraticSum, IsTheParabolaThroughItsPoint) {
  calib::ReducedSystem system;
  system.cost = 7.0;
  system.gradient = Eigen::Vector2d(1.0, -2.0);
  system.H = (Eigen::Matrix2d() << 4.0, 1.0, 1.0, 3.0).finished();
  const Eigen::VectorXd at = Eigen::Vector2d(0.5, 0.25);
  Eigen::VectorXd x = at;
  calib::QuadraticSum sum(system, at, 0.0, &x);
  const SharedState none;
  EXPECT_EQ(sum.solve_states(none, {}), 7.0);
  const Eigen::Vector2d d(0.3, -0.7);
  x = at + d;
  const Eigen::Vector2d g = system.gradient + system.H * d;
  EXPECT_NEAR(sum.solve_states(none, {}), 7.0 + d.x() - 2 * d.y() + 0.5 * d.dot(system.H * d), 1e-14);
  calib::ReducedSystem here;
  sum.reduce(none, {}, here);
  EXPECT_LT((here.gradient - g).norm(), 1e-14);
  EXPECT_EQ(here.H, system.H);
  EXPECT_EQ(here.cost, sum.solve_states(none, {}));
  // Damped, of its diagonal alone.
  calib::QuadraticSum damped(system, at, 0.1, &x);
  damped.reduce(none, {}, here);
  EXPECT_NEAR(here.H(0, 0), 4.4, 1e-14);
  EXPECT_EQ(here.H(0, 1), 1.0);
}

}  // namespace
}  // namespace octant::test
