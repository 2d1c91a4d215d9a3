// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/chain_solver.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

namespace octant {
namespace {

template <int N>
Eigen::Matrix<double, N, N> random_normal_matrix(std::mt19937& random) {
  std::normal_distribution<double> n;
  const auto J = Eigen::Matrix<double, N + 3, N>::NullaryExpr([&] { return n(random); }).eval();
  // Units of very different size, as metres and radians beside seconds.
  const auto scale =
      Eigen::Matrix<double, N, 1>::NullaryExpr([&] { return std::pow(10.0, 3.0 * n(random)); }).eval();
  return scale.asDiagonal() * (J.transpose() * J) * scale.asDiagonal();
}

/// A factor of which reciprocals stand on the diagonal.
template <int N>
void expect_factor_of(const Eigen::Matrix<double, N, N>& A) {
  SmallCholesky<N> ours;
  ASSERT_TRUE(ours.factor(A));
  const Eigen::Matrix<double, N, N> L = A.llt().matrixL();
  for (int i = 0; i < N; ++i) {
    EXPECT_NEAR(ours.L[i][i] * L(i, i), 1.0, 1e-10);  // rounding times the squared ratio of pivots
    for (int j = 0; j < i; ++j) EXPECT_NEAR(ours.L[i][j], L(i, j), 1e-10 * L.row(i).norm());
  }
}

TEST(SmallCholesky, IsEigensFactor) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    expect_factor_of<1>(random_normal_matrix<1>(random));
    expect_factor_of<3>(random_normal_matrix<3>(random));
    expect_factor_of<7>(random_normal_matrix<7>(random));
  }
}

TEST(SmallCholesky, SaysWhereABlockIsNotPositiveDefinite) {
  SmallCholesky<3> factor;
  Eigen::Matrix3d A = Eigen::Vector3d(4.0, 1.0, 9.0).asDiagonal();
  EXPECT_TRUE(factor.factor(A));
  A(1, 0) = A(0, 1) = 2.0;  // the second pivot is zero
  EXPECT_FALSE(factor.factor(A));
  A(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factor.factor(A));
}

}  // namespace
}  // namespace octant
