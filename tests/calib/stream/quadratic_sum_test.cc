// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/quadratic_sum.h"

#include <gtest/gtest.h>

namespace octant::test {
namespace quadratic_sum_test {

/// Three parameters: the first two are coupled, and so are the last two.
calib::SystemParts two_parts() {
  calib::SystemParts data;
  data.add({{0, 1}, {7.0, Eigen::Vector2d(1.0, -2.0), (Eigen::Matrix2d() << 4.0, 1.0, 1.0, 3.0).finished()}});
  data.add(
      {{1, 2}, {2.0, Eigen::Vector2d(0.5, 0.25), (Eigen::Matrix2d() << 2.0, -1.0, -1.0, 5.0).finished()}});
  return data;
}

// Sum of a log without its arrivals: a parabola in all parameters.
TEST(QuadraticSum, IsTheParabolaThroughItsPoint) {
  const Eigen::Vector3d g(1.0, -1.5, 0.25);
  const Eigen::Matrix3d H = (Eigen::Matrix3d() << 4.0, 1.0, 0.0, 1.0, 5.0, -1.0, 0.0, -1.0, 5.0).finished();
  const Eigen::VectorXd at = Eigen::Vector3d(0.5, 0.25, -1.0);
  Eigen::VectorXd x = at;
  calib::QuadraticSum sum(two_parts(), at, 0.0, &x);
  const SharedState none;
  EXPECT_EQ(sum.solve_states(none, {}), 9.0);
  const Eigen::Vector3d d(0.3, -0.7, 0.2);
  x = at + d;
  EXPECT_NEAR(sum.solve_states(none, {}), 9.0 + d.dot(g) + 0.5 * d.dot(H * d), 1e-14);
  calib::ReducedSystem here;
  sum.reduce(none, {}, here);
  EXPECT_LT((here.gradient - g - H * d).norm(), 1e-14);
  EXPECT_EQ(here.H, H);
  EXPECT_NEAR(here.cost, sum.solve_states(none, {}), 1e-14);
  // Damped, of its diagonal alone.
  calib::QuadraticSum damped(two_parts(), at, 0.1, &x);
  damped.reduce(none, {}, here);
  EXPECT_NEAR(here.H(0, 0), 4.4, 1e-14);
  EXPECT_EQ(here.H(0, 1), 1.0);
}

TEST(QuadraticSum, IsAskedForByItsParts) {
  const Eigen::VectorXd at = Eigen::Vector3d(0.5, 0.25, -1.0);
  const Eigen::VectorXd x = at + Eigen::Vector3d(0.3, -0.7, 0.2);
  calib::QuadraticSum sum(two_parts(), at, 0.0, &x);
  const std::vector<calib::SystemPart> here = sum.reduce_each({}, {});
  ASSERT_EQ(here.size(), 2U);
  EXPECT_EQ(sum.columns_of(1), (std::vector<int>{1, 2}));
  const Eigen::Vector2d d(-0.7, 0.2), g(0.5, 0.25);
  const Eigen::Matrix2d H = two_parts().parts()[1].system.H;
  EXPECT_NEAR(here[1].system.cost, 2.0 + d.dot(g) + 0.5 * d.dot(H * d), 1e-14);
  EXPECT_EQ(here[1].system.cost, sum.costs()[1]);
  EXPECT_LT((here[1].system.gradient - g - H * d).norm(), 1e-14);
}

}  // namespace quadratic_sum_test
}  // namespace octant::test
