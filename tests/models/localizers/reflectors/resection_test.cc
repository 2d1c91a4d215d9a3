// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/reflectors/resection.h"

#include <cmath>
#include <iostream>
#include <numbers>

#include <gtest/gtest.h>

#include "models/physics/pose.h"
#include "models/simulator/random.h"

namespace octant {
namespace resection_test {

using Points = std::array<Eigen::Vector2d, 3>;
constexpr double kDegree = std::numbers::pi / 180.0;

Eigen::Vector2d direction(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

std::array<double, 3> bearings(const Points& p, const Eigen::Vector2d& at, double heading_rad) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = wrap_angle(std::atan2(p[i].y() - at.y(), p[i].x() - at.x()) - heading_rad);
  return out;
}

Points sights(const std::array<double, 3>& bearing_rad) {
  return {direction(bearing_rad[0]), direction(bearing_rad[1]), direction(bearing_rad[2])};
}

/// Smieszek's table 2: two bearing angles in degrees, and the position computed from them in metres.
struct Row {
  double alpha_deg, beta_deg, x_m, y_m;
};
constexpr std::array<Row, 6> kTable2 = {{{57.1, 64.8, 5.0, 12.0},
                                         {58.6, 67.3, 6.5, 12.0},
                                         {59.9, 70.0, 8.0, 12.0},
                                         {61.3, 72.5, 9.2, 12.3},
                                         {62.0, 73.6, 9.7, 12.5},
                                         {62.7, 74.5, 10.0, 12.8}}};

/// The paper does not print where its reflectors stand. A least-squares fit of three points to the twelve
/// angles (alpha between the first two, beta between the last two; residuals 0.02 deg, angles are printed to
/// 0.1) lands within a metre or so of three corners of a hall of 35 x 40 m, and these corners explain every
/// angle to 0.08 deg, what a position printed to 0.1 m leaves open.
const Points kCorners = {{{0.0, 40.0}, {35.0, 40.0}, {35.0, 0.0}}};

TEST(Table2, ItsReflectorsAreThreeCornersOfAHall) {
  for (const Row& row : kTable2) {
    const auto b = bearings(kCorners, {row.x_m, row.y_m}, 0.0);
    // Rounding: 0.05 deg of the angle, and 0.05 m in x and y at no less than 27 m from a reflector, twice: up
    // to 0.1 deg each.
    EXPECT_NEAR((b[0] - b[1]) / kDegree, row.alpha_deg, 0.09);
    EXPECT_NEAR((b[1] - b[2]) / kDegree, row.beta_deg, 0.09);
  }
}

TEST(Table2, PositionsToThePrintedDigit) {
  for (const Row& row : kTable2) {
    const auto p = intersect_sight_circles(kCorners, direction(-row.alpha_deg * kDegree),
                                           direction(-row.beta_deg * kDegree));
    ASSERT_TRUE(p);
    std::cout << row.alpha_deg << " " << row.beta_deg << ": " << p->transpose() << " (" << row.x_m << " "
              << row.y_m << ")\n";
    EXPECT_DOUBLE_EQ(std::round(p->x() * 10) / 10, row.x_m);
    EXPECT_DOUBLE_EQ(std::round(p->y() * 10) / 10, row.y_m);
  }
}

TEST(Resection, IsExact) {
  Random random(11);
  int count = 0;
  for (int k = 0; k < 500; ++k) {
    Points p;
    for (auto& point : p) point = {random.uniform(-10, 10), random.uniform(-10, 10)};
    const Eigen::Vector2d at(random.uniform(-10, 10), random.uniform(-10, 10));
    const double heading = random.uniform(-3, 3);
    const auto pose = resect(p, sights(bearings(p, at, heading)));
    // Near the danger circle rounding is magnified: judge where the observer is well off it.
    const Eigen::Vector2d a = p[1] - p[0], b = p[2] - p[0];
    const double area = a.x() * b.y() - a.y() * b.x();
    const Eigen::Vector2d centre = p[0] + Eigen::Vector2d(b.y() * a.squaredNorm() - a.y() * b.squaredNorm(),
                                                          a.x() * b.squaredNorm() - b.x() * a.squaredNorm()) /
                                              (2 * area);
    const double radius = (p[0] - centre).norm();
    if (std::abs((at - centre).norm() - radius) < 0.05 * radius || std::abs(area) < 1) continue;
    ASSERT_TRUE(pose) << k;
    EXPECT_LT((pose->p_map_m - at).norm(), 1e-9) << k;
    EXPECT_LT(std::abs(wrap_angle(pose->heading_rad() - heading)), 1e-9) << k;
    ++count;
  }
  EXPECT_GT(count, 300);
}

TEST(Resection, TakesCirclesThatAreLines) {
  // In line with the first two, between them and outside; and points in a row, which is no danger circle.
  const Points p = {{{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}}};
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(-2.0, 0.0), Eigen::Vector2d(7.0, 0.0)}) {
    const auto pose = resect(p, sights(bearings(p, at, 0.3)));
    ASSERT_TRUE(pose) << at.transpose();
    EXPECT_LT((pose->p_map_m - at).norm(), 1e-12);
  }
  const Points row = {{{0.0, 0.0}, {4.0, 0.0}, {9.0, 0.0}}};
  const auto pose = resect(row, sights(bearings(row, {3.0, 2.0}, -1.0)));
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->p_map_m - Eigen::Vector2d(3.0, 2.0)).norm(), 1e-12);
}

TEST(Resection, FindsNothingOnTheDangerCircle) {
  const Points p = {{{5.0, 0.0}, {0.0, 5.0}, {-5.0, 0.0}}};
  EXPECT_FALSE(resect(p, sights(bearings(p, {0.0, -5.0}, 0.3))));
  EXPECT_FALSE(resect(p, sights(bearings(p, {3.0, -4.0}, 0.3))));
  EXPECT_TRUE(resect(p, sights(bearings(p, {3.0, -3.5}, 0.3))));
}

TEST(Resection, FindsNothingWhereThereIsNothing) {
  const Points p = {{{5.0, 0.0}, {0.0, 5.0}, {-5.0, 1.0}}};
  auto b = bearings(p, {1.0, -2.0}, 0.3);
  EXPECT_TRUE(resect(p, sights(b)));
  b[0] = wrap_angle(b[0] + std::numbers::pi);  // the circles are the same, the reflector would be behind
  EXPECT_FALSE(resect(p, sights(b)));
  EXPECT_FALSE(resect({p[0], p[0], p[0]}, sights(b)));
  EXPECT_FALSE(resect(p, sights({std::nan(""), 0.0, 1.0})));
}

}  // namespace resection_test
}  // namespace octant
