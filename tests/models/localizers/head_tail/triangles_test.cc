// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Triangles over base lines: the vertex by its defining distances, the combination against weighted least
// squares iterated to its end.
#include "models/localizers/head_tail/triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "models/changes/chi_square.h"

namespace octant {
namespace triangles_test {

using Point = Eigen::Vector2d;

/// Rounding of a solution from lengths of some ten metres, magnified by distance over height near a base
/// line: 1e-15 * 10 * 100.
constexpr double kVertex_m = 1e-9;

TEST(Triangles, VertexHasTheSidesAndTheSideAskedFor) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> at(-10.0, 10.0);
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector2d B(at(random), at(random)), C(at(random), at(random)), A(at(random), at(random));
    const double b = (A - C).norm(), c = (A - B).norm();
    const double across = (C - B).x() * (A - B).y() - (C - B).y() * (A - B).x();
    const double height = std::abs(across) / (C - B).norm();
    const auto side = across > 0 ? BaseLineSide::kLeft : BaseLineSide::kRight;
    const auto found = triangle_vertex(B, C, b, c, side);
    if (!found) {
      EXPECT_LT(height, 1e-6);  // flat: rounding may leave no triangle
      continue;
    }
    // Rounding of the sides, magnified by c / height as promised.
    const double allowed = 1e-13 * (1 + (b + c) * (b + c) / std::max(height, 1e-9));
    EXPECT_LT((*found - A).norm(), allowed) << k;
    const auto mirrored =
        triangle_vertex(B, C, b, c, side == BaseLineSide::kLeft ? BaseLineSide::kRight : BaseLineSide::kLeft);
    ASSERT_TRUE(mirrored);
    EXPECT_NEAR((*mirrored - B).norm(), c, 1e-9);
    EXPECT_NEAR((*mirrored - C).norm(), b, 1e-9);
    EXPECT_NEAR((*mirrored - *found).norm(), 2 * height, 1e-6);
  }
}

TEST(Triangles, NoVertexWhereTheSidesMakeNone) {
  const Eigen::Vector2d B(0, 0), C(4, 0);
  EXPECT_FALSE(triangle_vertex(B, C, 1.0, 2.0, BaseLineSide::kLeft));
  EXPECT_FALSE(triangle_vertex(B, C, 9.0, 2.0, BaseLineSide::kLeft));
  EXPECT_FALSE(triangle_vertex(B, B, 2.0, 2.0, BaseLineSide::kLeft));
  EXPECT_FALSE(triangle_vertex(B, C, 0.0, 4.0, BaseLineSide::kLeft));
  EXPECT_FALSE(triangle_vertex(B, C, NAN, 4.0, BaseLineSide::kLeft));
}

struct Squares {
  Eigen::Vector2d p;
  Eigen::Matrix2d information;
  double cost = 0.0;
};

/// Gauss and Newton to the end, from near the truth.
Squares least_squares(const std::vector<StationRange>& stations, Eigen::Vector2d p) {
  Squares out;
  for (int i = 0; i < 50; ++i) {
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    out.information.setZero();
    out.cost = 0;
    for (const StationRange& s : stations) {
      const Eigen::Vector2d u = (p - s.p_m).normalized();
      const double r = s.distance_m - (p - s.p_m).norm(), w = 1 / (s.sigma_m * s.sigma_m);
      out.information += w * u * u.transpose();
      g += w * r * u;
      out.cost += w * r * r;
    }
    p += out.information.ldlt().solve(g);
  }
  out.p = p;
  return out;
}

/// Stations around a place in the middle third of a hall.
std::vector<StationRange> stations_around(const Eigen::Vector2d& p, double noise_sigmas,
                                          std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<StationRange> stations;
  for (const auto& [x, y, sigma] : {std::array{0.0, 0.5, 0.002}, std::array{12.0, 0.0, 0.001},
                                    std::array{11.0, 9.0, 0.004}, std::array{-0.5, 8.5, 0.002}}) {
    const Eigen::Vector2d at(x, y);
    stations.push_back({at, (p - at).norm() + noise_sigmas * sigma * normal(random), sigma});
  }
  return stations;
}

/// Largest distance from least squares, in sigmas, over many places with that much noise.
double worst_sigmas_from_least_squares(double noise_sigmas) {
  std::mt19937_64 random(2);
  // Where no triangle is flat: one that is left out would lose some of its stations' weight.
  std::uniform_real_distribution<double> x(5.0, 7.0), y(1.5, 2.5);
  TriangleSolver solver(4, 0.2, 4.0);
  double worst = 0.0;
  int compared = 0;
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector2d truth(x(random), y(random));
    const auto stations = stations_around(truth, noise_sigmas, random);
    if (solver.solve(stations) != TriangleStatus::kOk || solver.places()[0].left_out >= 0) continue;
    ++compared;
    const TrianglePoint& place = solver.places()[0];
    const Squares best = least_squares(stations, truth);
    const Eigen::Vector2d off = place.p_m - best.p;
    const double squares = off.dot(best.information * off);
    worst = std::max(worst, std::sqrt(squares));
    // At the minimum the cost is flat: off it grows by the squares.
    EXPECT_NEAR(place.cost - best.cost, squares, 0.02 * squares + 1e-9);
  }
  EXPECT_GT(compared, 290);
  return worst;
}

/// There is no first-order effect: a tenth of the noise changes the distance by a hundredth.
TEST(Triangles, TogetherTheyAreLeastSquaresToFirstOrder) {
  const double coarse = worst_sigmas_from_least_squares(1.0), fine = worst_sigmas_from_least_squares(0.1);
  EXPECT_LT(coarse, 0.5);
  EXPECT_LT(fine, coarse / 50);
}

TEST(Triangles, GainsAreTheNumericDerivatives) {
  std::mt19937_64 random(3);
  TriangleSolver solver(4, 0.2, 4.0);
  const Eigen::Vector2d truth(5.3, 4.1);
  auto stations = stations_around(truth, 0.0, random);
  ASSERT_EQ(solver.solve(stations), TriangleStatus::kOk);
  const std::vector<Eigen::Vector2d> gain = solver.places()[0].gain;
  ASSERT_EQ(gain.size(), stations.size());
  for (std::size_t s = 0; s < stations.size(); ++s) {
    constexpr double kStep = 1e-5;
    Eigen::Vector2d at[2];
    for (const int side : {0, 1}) {
      auto moved = stations;
      moved[s].distance_m += side == 0 ? -kStep : kStep;
      ASSERT_EQ(solver.solve(moved), TriangleStatus::kOk);
      at[side] = solver.places()[0].p_m;
    }
    EXPECT_LT((gain[s] - (at[1] - at[0]) / (2 * kStep)).norm(), 1e-4) << s;
  }
}

TEST(Triangles, TheStationThatLiesIsLeftOut) {
  std::mt19937_64 random(4);
  TriangleSolver solver(4, 0.2, 4.0);
  const Eigen::Vector2d truth(6.1, 4.4);
  for (std::size_t liar = 0; liar < 4; ++liar) {
    auto stations = stations_around(truth, 0.3, random);
    stations[liar].distance_m += 0.4;
    ASSERT_EQ(solver.solve(stations), TriangleStatus::kOk) << liar;
    EXPECT_EQ(solver.places()[0].left_out, static_cast<int>(liar));
    EXPECT_LT((solver.places()[0].p_m - truth).norm(), 0.02) << liar;
  }
}

TEST(Triangles, TwoStationsLeaveTwoPlacesAndOneLeavesNone) {
  TriangleSolver solver(4, 0.2, 4.0);
  const std::vector<StationRange> two = {{{0, 0}, 5.0, 0.01}, {{8, 0}, 5.0, 0.01}};
  ASSERT_EQ(solver.solve(two), TriangleStatus::kOk);
  ASSERT_EQ(solver.places().size(), 2U);
  for (const TrianglePoint& place : solver.places()) EXPECT_NEAR(std::abs(place.p_m.y()), 3.0, 1e-12);
  EXPECT_NEAR(solver.places()[0].p_m.y(), -solver.places()[1].p_m.y(), 1e-12);
  EXPECT_EQ(solver.solve(std::span(two).first(1)), TriangleStatus::kTooFew);
  const std::vector<StationRange> apart = {{{0, 0}, 1.0, 0.01}, {{8, 0}, 1.0, 0.01}};
  EXPECT_EQ(solver.solve(apart), TriangleStatus::kContradiction);
}

/// Upper quantiles as tables print them, z = 2.3263 is 99 %, z = 1.6449 is 95 %; the approximation is good to
/// half a per cent from three degrees of freedom on.
TEST(Triangles, GateIsChiSquaresQuantile) {
  EXPECT_NEAR(chi2_gate(5, 2.3263479) / 15.0863, 1.0, 0.006);
  EXPECT_NEAR(chi2_gate(10, 2.3263479) / 23.2093, 1.0, 0.006);
  EXPECT_NEAR(chi2_gate(3, 1.6448536) / 7.8147, 1.0, 0.006);
  EXPECT_NEAR(chi2_gate(20, 1.6448536) / 31.4104, 1.0, 0.006);
  EXPECT_EQ(chi2_gate(0, 3.0), 0.0);
}

TEST(TriangleVertex, IsExactInAllOrientations) {
  // Apexes with acute, right and obtuse angles at B and C, beyond both ends and near the base line; figure 5
  // turned all round.
  const std::vector<Point> apexes = {{3, 4},     {0, 2},     {6, 1},    {-2, 1}, {9, 3},
                                     {-5, 0.01}, {11, 0.01}, {3, 0.02}, {6, 7},  {2.5, 30}};
  const Point B(1.3, -0.7);
  double worst_m = 0;
  for (int turn = 0; turn < 72; ++turn) {
    const Eigen::Rotation2Dd R(turn * M_PI / 36);
    const Point C = B + R * Point(6, 0);
    for (const Point& apex : apexes) {
      for (const BaseLineSide side : {BaseLineSide::kLeft, BaseLineSide::kRight}) {
        const Point A = B + R * Point(apex.x(), side == BaseLineSide::kLeft ? apex.y() : -apex.y());
        const auto found = triangle_vertex(B, C, (A - C).norm(), (A - B).norm(), side);
        ASSERT_TRUE(found);
        worst_m = std::max(worst_m, (*found - A).norm());
      }
    }
  }
  EXPECT_LT(worst_m, kVertex_m);
  RecordProperty("worst_pm", std::to_string(1e12 * worst_m));
}

TEST(TriangleVertex, TheLongestSideNeedNotFaceAnObtuseAngle) {
  // c is the longest side, yet the angle at C is acute (82 degrees): the paper's step 5 would take its
  // supplement.
  const auto found = triangle_vertex({0, 0}, {8, 0}, 7.0, 9.9, BaseLineSide::kLeft);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->norm(), 9.9, 1e-12);
  EXPECT_NEAR((*found - Point(8, 0)).norm(), 7.0, 1e-12);
}

TEST(TriangleVertex, SidesThatDoNotCloseGiveNothing) {
  EXPECT_FALSE(triangle_vertex({0, 0}, {8, 0}, 3.0, 4.9, BaseLineSide::kLeft));
  EXPECT_FALSE(triangle_vertex({0, 0}, {8, 0}, 1.0, 9.1, BaseLineSide::kLeft));
  EXPECT_FALSE(triangle_vertex({1, 1}, {1, 1}, 3.0, 3.0, BaseLineSide::kLeft));
  EXPECT_FALSE(triangle_vertex({0, 0}, {8, 0}, std::nan(""), 4.9, BaseLineSide::kLeft));
}

TEST(TriangleSolver, TwoStationsAgainstTwoAreAContradiction) {
  const Point place(3, 2);
  std::vector<StationRange> stations;
  for (const Point& p : {Point(0, 0), Point(8, 0), Point(8, 6), Point(0, 6)})
    stations.push_back({p, (p - place).norm(), 0.003});
  TriangleSolver solver(4, 0.05, 4.0);
  ASSERT_EQ(solver.solve(stations), TriangleStatus::kOk);
  ASSERT_EQ(solver.places().size(), 1u);
  EXPECT_LT((solver.places()[0].p_m - place).norm(), 1e-12);
  stations[0].distance_m += 0.5;
  ASSERT_EQ(solver.solve(stations), TriangleStatus::kOk);
  EXPECT_EQ(solver.places()[0].left_out, 0);
  stations[1].distance_m += 1.1;
  EXPECT_EQ(solver.solve(stations), TriangleStatus::kContradiction);
  EXPECT_EQ(solver.solve(std::span(stations).first(1)), TriangleStatus::kTooFew);
}

}  // namespace triangles_test
}  // namespace octant
