// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/chain_solver.h"

#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

namespace octant {
namespace chain_solver_test {

template <int N>
Eigen::Matrix<double, N, N> random_normal_matrix(std::mt19937& random) {
  std::normal_distribution<double> n;
  const auto J = Eigen::Matrix<double, N + 3, N>::NullaryExpr([&] { return n(random); }).eval();
  // Units of very different size, such as metres, radians and seconds.
  const auto scale =
      Eigen::Matrix<double, N, 1>::NullaryExpr([&] { return std::pow(10.0, 3.0 * n(random)); }).eval();
  return scale.asDiagonal() * (J.transpose() * J) * scale.asDiagonal();
}

/// A factor with reciprocals on its diagonal.
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

/// A chain of random states that couple to their neighbours.
template <int N>
FixedChainSystem<N> random_chain(std::size_t count, std::mt19937& random) {
  std::normal_distribution<double> n;
  FixedChainSystem<N> system;
  system.resize(count);
  system.clear(0, count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto J = Eigen::Matrix<double, N + 3, 2 * N>::NullaryExpr([&] { return n(random); }).eval();
    const Eigen::Matrix<double, 2 * N, 2 * N> A = J.transpose() * J;
    system.D[k] += A.template topLeftCorner<N, N>() + Eigen::Matrix<double, N, N>::Identity();
    system.g[k] = Eigen::Matrix<double, N, 1>::NullaryExpr([&] { return n(random); });
    if (k + 1 == count) break;
    system.U[k] = A.template topRightCorner<N, N>();
    system.D[k + 1] += A.template bottomRightCorner<N, N>();
  }
  return system;
}

/// Reference: the step from the whole matrix.
template <int N>
Eigen::VectorXd by_sparse_matrix(const FixedChainSystem<N>& system, double lambda) {
  const auto count = static_cast<Eigen::Index>(system.D.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd g(N * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    g.segment<N>(N * k) = system.g[i];
    for (int r = 0; r < N; ++r)
      for (int c = 0; c < N; ++c) {
        entries.emplace_back(N * k + r, N * k + c, system.D[i](r, c) * (r == c ? 1.0 + lambda : 1.0));
        if (k + 1 == count) continue;
        entries.emplace_back(N * k + r, N * (k + 1) + c, system.U[i](r, c));
        entries.emplace_back(N * (k + 1) + c, N * k + r, system.U[i](r, c));
      }
  }
  Eigen::SparseMatrix<double> A(N * count, N * count);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(A);
  return -factor.solve(g);
}

template <int N>
void expect_step_of_the_whole_matrix() {
  std::mt19937 random(N);
  for (const std::size_t count : {1U, 2U, 3U, 512U, 513U, 1300U})  // of one sweep, and from both ends
    for (const double lambda : {0.0, 0.3}) {
      const FixedChainSystem<N> system = random_chain<N>(count, random);
      const Eigen::VectorXd whole = by_sparse_matrix(system, lambda);
      FixedChainStep<N> one, three;
      FixedChainSystem<N> taken = system, again = system;
      ASSERT_TRUE(one.solve(taken, lambda));
      ASSERT_TRUE(three.solve(again, lambda, 3));
      double gain = 0.0;
      for (std::size_t k = 0; k < count; ++k) {
        const Eigen::VectorXd there = whole.segment<N>(static_cast<Eigen::Index>(N * k));
        // The floor of a diagonal changes a step by 1e-9 of its size.
        EXPECT_LT((one.step()[k] - there).norm(), 1e-7 * whole.lpNorm<Eigen::Infinity>()) << k;
        EXPECT_EQ(one.step()[k], three.step()[k]) << "hangs on the number of threads";
        gain -= 0.5 * system.g[k].dot(there);
      }
      EXPECT_NEAR(one.gain(taken), gain, 1e-6 * gain);
    }
}

TEST(FixedChainStep, IsTheStepOfTheWholeMatrix) {
  expect_step_of_the_whole_matrix<3>();
  expect_step_of_the_whole_matrix<4>();
  expect_step_of_the_whole_matrix<6>();
}

TEST(FixedChainStep, SaysWhereAChainIsNotPositiveDefinite) {
  std::mt19937 random(8);
  for (const std::size_t bad : {std::size_t{3}, std::size_t{650}, std::size_t{1290}}) {
    FixedChainSystem<3> system = random_chain<3>(1300, random);
    system.D[bad](1, 1) = -1.0;
    EXPECT_FALSE(FixedChainStep<3>().solve(system, 0.0, 2)) << bad;
  }
}

}  // namespace chain_solver_test
}  // namespace octant
