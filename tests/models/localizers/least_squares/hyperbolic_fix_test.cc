// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/hyperbolic_fix.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/support/numeric.h"
#include "tests/support/statistics.h"

namespace octant {
namespace hyperbolic_fix_test {

using Three = std::array<PlanBeacon, 3>;

Eigen::Vector2d in_room(Random& random, double margin_m = 0.5) {
  return {random.uniform(margin_m, 10 - margin_m), random.uniform(margin_m, 10 - margin_m)};
}

/// Three beacons in different corners or halfway along walls of a 10 x 10 m room.
Three walls(Random& random, double height_m) {
  const Eigen::Vector2d places[8] = {{0, 0}, {5, 0}, {10, 0}, {10, 5}, {10, 10}, {5, 10}, {0, 10}, {0, 5}};
  const auto first = static_cast<int>(random.uniform(0, 8));
  Three three;
  for (int i = 0; i < 3; ++i)
    three[static_cast<std::size_t>(i)] = {places[(first + 3 * i) % 8], height_m * random.uniform()};
  return three;
}

std::array<double, 3> distances(const Three& b, const Eigen::Vector2d& p, double offset_m = 0.0) {
  return {slant_distance_m(b[0], p) + offset_m, slant_distance_m(b[1], p) + offset_m,
          slant_distance_m(b[2], p) + offset_m};
}

std::array<Eigen::Vector2d, 3> directions(const Three& b, const Eigen::Vector2d& p) {
  return {foreshortened(b[0], p), foreshortened(b[1], p), foreshortened(b[2], p)};
}

/// For level beacons the step is eq. 4 in the paper's half angles, x with cosines and y with sines, if the
/// second term has d(d1 - d0): with the printed d(d0 - d1) it goes the other way.
TEST(HyperbolicFix, StepIsEquation4) {
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    const Three b = walls(random, 0.0);
    const Eigen::Vector2d p = in_room(random);
    const auto step = hyperbolic_step(directions(b, p));
    ASSERT_TRUE(step);
    double psi[3];
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector2d to = b[static_cast<std::size_t>(i)].p_map_m - p;
      psi[i] = std::atan2(to.y(), to.x());
    }
    const double d12 = 2 * std::sin((psi[0] - psi[2]) / 2) * std::sin((psi[1] - psi[2]) / 2);
    const double d10 = 2 * std::sin((psi[2] - psi[0]) / 2) * std::sin((psi[1] - psi[0]) / 2);
    const Eigen::Vector2d by_d12 =
        -Eigen::Vector2d(std::cos((psi[0] + psi[1]) / 2), std::sin((psi[0] + psi[1]) / 2)) / d12;
    const Eigen::Vector2d by_d10 =
        -Eigen::Vector2d(std::cos((psi[2] + psi[1]) / 2), std::sin((psi[2] + psi[1]) / 2)) / d10;
    // Rounding, enlarged by the same small denominators.
    EXPECT_LT((step->by_d12 - by_d12).norm(), 1e-12 * by_d12.squaredNorm() + 1e-12) << k;
    EXPECT_LT((step->by_d10 - by_d10).norm(), 1e-12 * by_d10.squaredNorm() + 1e-12) << k;
  }
}

/// Eq. 4 inverts a small displacement, in space as in the plane: from the differences of distances due to a
/// displacement, the step gives the displacement.
TEST(HyperbolicFix, StepIsTheInverseOfTheDistances) {
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const Three b = walls(random, 3.0);
    const Eigen::Vector2d p = in_room(random);
    const auto step = hyperbolic_step(directions(b, p));
    ASSERT_TRUE(step);
    const auto differences = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
      const auto d = distances(b, at);
      return Eigen::Vector2d(d[1] - d[2], d[1] - d[0]);
    };
    Eigen::Matrix2d S;
    S << step->by_d12, step->by_d10;
    const Eigen::Matrix2d J = test::numeric_jacobian(differences, p);
    // Central differences at a step of 1 um are good to some 1e-10, times the size of the inverse.
    EXPECT_LT((S * J - Eigen::Matrix2d::Identity()).norm(), 1e-8 * (1 + S.norm())) << k;
    EXPECT_LT((step->by_distances().rowwise().sum()).norm(), 1e-12 * (1 + S.norm()))
        << "a common offset must not count";
  }
}

TEST(HyperbolicFix, FindsThePlaceWhateverTheOffset) {
  Random random(3);
  int iterations = 0;
  for (int k = 0; k < 300; ++k) {
    const Three b = walls(random, k % 2 == 0 ? 0.0 : 3.0);
    const Eigen::Vector2d p = in_room(random, 1.0);
    const Eigen::Vector2d start = p + Eigen::Vector2d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    const HyperbolicFix fix = hyperbolic_fix(b, distances(b, p, random.uniform(-20, 20)), start);
    ASSERT_TRUE(fix.converged) << k;
    EXPECT_LT((fix.p_map_m - p).norm(), 1e-7) << k;  // quadratic: the step after the last would be its square
    iterations += fix.iterations;
  }
  EXPECT_LT(iterations, 300 * 8) << "\"within a few iterations usually\"";
}

/// Section 4.2: the expression for the error against the errors themselves.
TEST(HyperbolicFix, ErrorExpressionIsThatOfTheSolutions) {
  Random random(4);
  std::cout << "seed 4\n";
  constexpr int kSamples = 2000;
  const double low = test::chi2_quantile(5e-5, kSamples), high = test::chi2_quantile(1 - 5e-5, kSamples);
  const std::array<double, 3> sigma_m = {1e-3, 2e-3, 0.5e-3};  // small, so that the hyperbolas are straight
  for (int k = 0; k < 5; ++k) {
    const Three b = walls(random, 2.0);
    const Eigen::Vector2d p = in_room(random, 2.0);
    const Eigen::Vector2d expected = hyperbolic_error_m(b, p, sigma_m);
    Eigen::Array2d squares = Eigen::Array2d::Zero();
    for (int i = 0; i < kSamples; ++i) {
      auto d = distances(b, p, 3.0);
      for (std::size_t j = 0; j < 3; ++j) d[j] += sigma_m[j] * random.normal();
      const HyperbolicFix fix = hyperbolic_fix(b, d, p);
      ASSERT_TRUE(fix.converged);
      squares += ((fix.p_map_m - p).array() / expected.array()).square();
    }
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_GT(squares[axis], low) << k << " axis " << axis;
      EXPECT_LT(squares[axis], high) << k << " axis " << axis;
    }
  }
}

TEST(HyperbolicFix, OtherIntersectionHasTheSameDifferences) {
  Random random(7);
  int found = 0;
  for (int k = 0; k < 300; ++k) {
    const Three b = {{{{4, 4}, random.uniform()}, {{6, 4}, random.uniform()}, {{5, 6}, random.uniform()}}};
    const Eigen::Vector2d p = in_room(random);
    const auto other = other_intersection(b, p);
    if (!other) continue;
    ++found;
    const auto here = distances(b, p), there = distances(b, *other);
    const double scale = 1 + (*other - p).norm();  // it may be far away
    EXPECT_NEAR(here[1] - here[0], there[1] - there[0], 1e-9 * scale * scale) << k;
    EXPECT_NEAR(here[2] - here[0], there[2] - there[0], 1e-9 * scale * scale) << k;
    EXPECT_GT((*other - p).norm(), 1e-6) << k;
  }
  EXPECT_GT(found, 30);
}

TEST(HyperbolicFix, ParallelHyperbolasHaveNoIntersection) {
  // On the extension of the line through two beacons their difference of distances equals the baseline
  // everywhere.
  const Three b = {{{{0, 0}, 0}, {{5, 0}, 0}, {{0, 5}, 0}}};
  const Eigen::Vector2d p(8, 0);
  EXPECT_FALSE(hyperbolic_step(directions(b, p)));
  EXPECT_FALSE(std::isfinite(hyperbolic_error_m(b, p, {1e-3, 1e-3, 1e-3}).x()));
  EXPECT_FALSE(hyperbolic_fix(b, distances(b, p), p).converged);
}

TEST(HyperbolicFix, DistancesThatNoPlaceHasDoNotConverge) {
  const Three b = {{{{0, 0}, 0}, {{10, 0}, 0}, {{0, 10}, 0}}};
  const HyperbolicFix fix =
      hyperbolic_fix(b, {0.0, 14.0, 3.0}, {4, 4});  // 14 m apart in distance, 10 m apart in the room
  EXPECT_FALSE(fix.converged);
  EXPECT_TRUE(fix.p_map_m.allFinite());
}

}  // namespace hyperbolic_fix_test
}  // namespace octant
