// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/planar.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace octant::test {
namespace planar_test {

constexpr double kRounding = 4e-16;

/// Small, middling and large angles of both signs, and those about half a turn.
std::vector<double> angles() {
  std::vector<double> out = {0.0, 1e-300, M_PI, M_PI - 1e-9, -M_PI + 1e-9, M_PI / 2, -M_PI / 2};
  for (double a = 1e-12; a < M_PI; a *= 1.7) {
    out.push_back(a);
    out.push_back(-a);
  }
  return out;
}

TEST(PlanarTurn, IsCosineAndSineOfItsAngle) {
  for (const double a : angles()) {
    const PlanarTurn turn(a);
    EXPECT_NEAR(turn.cosine, std::cos(a), kRounding) << a;
    EXPECT_NEAR(turn.sine, std::sin(a), kRounding * std::max(std::abs(a), 1e-3)) << a;
    EXPECT_NEAR(turn.angle_rad(), a, 2 * kRounding * std::max(std::abs(a), 1e-3)) << a;
  }
}

TEST(PlanarTurn, OfAQuaternionAndBetweenTwo) {
  for (const double a : angles())
    for (const double b : {0.0, 0.3, -2.9, 3.1}) {
      const Pose T = Pose::planar(0, 0, a), U = Pose::planar(0, 0, b);
      EXPECT_NEAR(wrap_angle(PlanarTurn(T.rotation).angle_rad() - T.heading_rad()), 0.0, 1e-15);
      EXPECT_NEAR(wrap_angle(between(PlanarTurn(T.rotation), PlanarTurn(U.rotation)).angle_rad() - (b - a)),
                  0.0, 2e-15);
    }
}

TEST(PlanarNode, ComesBackAsThePoseThatItWas) {
  for (const double a : angles()) {
    const Pose T = Pose::planar(3.0, -4.0, a), back = PlanarNode(T).pose();
    EXPECT_EQ(back.translation_m, T.translation_m);
    EXPECT_LT(std::min((back.rotation.coeffs() - T.rotation.coeffs()).norm(),
                       (back.rotation.coeffs() + T.rotation.coeffs()).norm()),
              1e-15)
        << a;
  }
}

TEST(PlanarNode, StaysAUnitVectorOverAMillionSteps) {
  std::mt19937 random(3);
  std::normal_distribution<double> n;
  PlanarNode node(0.0, 0.0, PlanarTurn(0.4));
  double heading = 0.4;
  for (int i = 0; i < 1'000'000; ++i) {
    const double turn = 0.3 * n(random);
    node = node.moved(1e-3, 0.0, turn);
    heading += turn;
  }
  EXPECT_NEAR(std::hypot(node.heading.cosine, node.heading.sine), 1.0, kRounding);
  EXPECT_NEAR(wrap_angle(node.heading.angle_rad() - heading), 0.0, 1e-9);
  EXPECT_NEAR(node.x_m, 1000.0, 1e-6);
}

TEST(PlanarInterval, GoesTheShorterWay) {
  const PlanarNode a(1.0, 2.0, PlanarTurn(3.0)), b(2.0, 4.0, PlanarTurn(-3.0));
  const PlanarInterval interval(a, b);
  EXPECT_NEAR(interval.turn_rad, 2 * M_PI - 6.0, 1e-15);
  const PlanarNode middle = interval.at(0.5);
  EXPECT_DOUBLE_EQ(middle.x_m, 1.5);
  EXPECT_DOUBLE_EQ(middle.y_m, 3.0);
  EXPECT_NEAR(std::abs(middle.heading.angle_rad()), M_PI, 1e-15);
}

}  // namespace planar_test
}  // namespace octant::test
