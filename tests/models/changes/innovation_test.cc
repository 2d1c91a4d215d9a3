// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Innovation of a second visit, compared with the quadratic form that it represents.
#include "models/changes/innovation.h"

#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace octant {
namespace innovation_test {

Eigen::MatrixXd random_positive(Eigen::Index n, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(n, n);
  for (double& a : A.reshaped()) a = normal(random);
  return A * A.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
}

/// d'(P + N^-1)^-1 d, whether the second visit comes as an estimate or as information and gradient.
TEST(Innovation, SquaresAreThoseOfTheDifference) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 50; ++k) {
    const Eigen::Index n = 2 + k % 5;
    const Eigen::MatrixXd P = random_positive(n, random), N = random_positive(n, random);
    Eigen::VectorXd d(n);
    for (double& x : d) x = normal(random);
    const Eigen::MatrixXd covariance = P + N.inverse();
    const double expected = d.dot(covariance.ldlt().solve(d));
    const Innovation by_difference = innovation_of_difference(d, covariance),
                     by_information = innovation_of_information(P, N, N * d);
    EXPECT_NEAR(by_difference.y.squaredNorm(), expected, 1e-8 * expected) << k;
    EXPECT_NEAR(by_information.y.squaredNorm(), expected, 1e-8 * expected) << k;
    EXPECT_LT((by_information.B * d - by_information.y).norm(), 1e-8 * by_information.y.norm()) << k;
    EXPECT_EQ(by_information.degrees_of_freedom, static_cast<int>(n));
  }
}

/// A direction that the visit does not determine is not a degree of freedom.
TEST(Innovation, WhatIsNotToldDoesNotCount) {
  std::mt19937_64 random(2);
  const Eigen::MatrixXd P = random_positive(4, random);
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(4, 4);
  N.topLeftCorner(2, 2) = random_positive(2, random);
  const Eigen::VectorXd d = Eigen::Vector4d(1, -2, 5, 7);
  const Innovation found = innovation_of_information(P, N, N * d);
  EXPECT_EQ(found.degrees_of_freedom, 2);
  const Eigen::Matrix2d covariance =
      P.topLeftCorner<2, 2>() + Eigen::Matrix2d(N.topLeftCorner<2, 2>()).inverse();
  EXPECT_NEAR(found.y.squaredNorm(), d.head<2>().dot(covariance.ldlt().solve(d.head<2>())), 1e-8);
}

/// A deployment in which everything was surveyed and is fixed.
TEST(Innovation, OfNothingIsNothing) {
  const Innovation found =
      innovation_of_information(Eigen::MatrixXd(0, 0), Eigen::MatrixXd(0, 0), Eigen::VectorXd(0));
  EXPECT_EQ(found.degrees_of_freedom, 0);
  EXPECT_EQ(found.y.size(), 0);
}

}  // namespace innovation_test
}  // namespace octant
