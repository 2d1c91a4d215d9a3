// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/observed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <Eigen/LU>

#include "models/trajectory/chain_solver.h"
#include "models/trajectory/linearise.h"

namespace octant::test {
namespace observed_test {

/// J'J of random rows whose unknowns are in metres, radians and nanoseconds.
NodeBlock information_of(int rows, int unknowns, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  NodeBlock A = NodeBlock::Zero(unknowns, unknowns);
  for (int k = 0; k < rows; ++k) {
    NodeVector row(unknowns);
    for (int i = 0; i < unknowns; ++i) row[i] = normal(random) * std::pow(10.0, 3 * i - 6);
    A += row * row.transpose();
  }
  return A;
}

TEST(Observed, CovarianceIsTheInverseWhateverTheUnits) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const NodeBlock A = information_of(12, 4, seed);
    const ObservedState<NodeBlock> observed(A);
    ASSERT_TRUE(observed.all()) << "seed " << seed;
    const NodeVector scale = A.diagonal().cwiseSqrt();
    const Eigen::Matrix4d scaled = scale.cwiseInverse().asDiagonal() * A * scale.cwiseInverse().asDiagonal();
    const Eigen::Matrix4d expected = scaled.fullPivLu().inverse();
    const Eigen::Matrix4d found = scale.asDiagonal() * observed.covariance() * scale.asDiagonal();
    // The scaled matrices of these seeds have condition numbers below a thousand.
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-10 * expected.cwiseAbs().maxCoeff())
        << "seed " << seed;
    const NodeVector b = NodeVector::LinSpaced(4, 1.0, 4.0);
    EXPECT_LT((observed.solve(b) - observed.covariance() * b).norm(), 1e-12 * observed.solve(b).norm());
  }
}

TEST(Observed, FewerRowsThanUnknownsLeaveADirectionOpen) {
  for (unsigned seed = 1; seed <= 20; ++seed)
    EXPECT_FALSE(ObservedState<NodeBlock>(information_of(3, 4, seed)).all()) << "seed " << seed;
}

TEST(Observed, WhatNothingTouchesIsOpenAndNothingIsNaN) {
  Eigen::Matrix3d A = Eigen::Vector3d(1e6, 1e-6, 0.0).asDiagonal();
  EXPECT_FALSE(ObservedState<Eigen::Matrix3d>(A).all());
  A(2, 2) = 1e-30;  // little, but all that there is of it is its own
  EXPECT_TRUE(ObservedState<Eigen::Matrix3d>(A).all());
  A(2, 2) = -1.0;
  EXPECT_FALSE(ObservedState<Eigen::Matrix3d>(A).all());
  A(2, 2) = NAN;
  EXPECT_FALSE(ObservedState<Eigen::Matrix3d>(A).all());
}

TEST(Observed, ADirectionCountsByWhatTheOthersLeaveToIt) {
  const auto with_share = [](double share) {
    Eigen::Matrix2d A;
    A << 1.0, std::sqrt(1.0 - share), std::sqrt(1.0 - share), 1.0;
    return ObservedState<Eigen::Matrix2d>(A).all();
  };
  EXPECT_TRUE(with_share(10 * kUnobserved));
  EXPECT_FALSE(with_share(0.1 * kUnobserved));
}

TEST(Observed, VagueAnglesAreTheTurnsOfThePoseAlone) {
  NodeBlock planar = NodeBlock::Zero(4, 4), spatial = NodeBlock::Zero(7, 7);
  add_vague_angles(Motion::kPlanar, planar);
  add_vague_angles(Motion::kSpatial, spatial);
  EXPECT_EQ(NodeVector(planar.diagonal()), NodeVector(Eigen::Vector4d(0, 0, kVagueAngle, 0)));
  EXPECT_EQ(spatial.diagonal().head(3).norm() + spatial(6, 6), 0.0);
  for (int i = 3; i < 6; ++i) EXPECT_NEAR(std::sqrt(1.0 / spatial(i, i)), M_PI, 1e-12);
}

TEST(SmallCholesky, FactorsAndSolves) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Eigen::Matrix<double, 5, 5> root;
    for (double& v : root.reshaped()) v = normal(random);
    const Eigen::Matrix<double, 5, 5> A =
        root * root.transpose() + 0.1 * Eigen::Matrix<double, 5, 5>::Identity();
    SmallCholesky<5> factor;
    ASSERT_TRUE(factor.factor(A));
    Eigen::Matrix<double, 5, 1> b = Eigen::Matrix<double, 5, 1>::LinSpaced(-2.0, 2.0);
    const Eigen::Matrix<double, 5, 1> expected = A.fullPivLu().solve(b);
    factor.forward(b);
    factor.backward(b);
    EXPECT_LT((b - expected).norm(), 1e-11 * (1 + expected.norm())) << "seed " << seed;
    EXPECT_FALSE(factor.factor(A - 10 * A.trace() * Eigen::Matrix<double, 5, 5>::Identity()));
  }
}

TEST(SmallCholesky, TakesAPivotAsItIsAccepted) {
  SmallCholesky<2> factor;
  const Eigen::Matrix2d A = Eigen::Vector2d(4.0, 0.0).asDiagonal();
  EXPECT_FALSE(factor.factor(A));
  factor.factor(A, [](double pivot) { return pivot > 0 ? pivot : 25.0; });
  Eigen::Vector2d b(8.0, 50.0);
  factor.forward(b);
  factor.backward(b);
  EXPECT_DOUBLE_EQ(b[0], 2.0);
  EXPECT_DOUBLE_EQ(b[1], 2.0);
}

}  // namespace observed_test
}  // namespace octant::test
