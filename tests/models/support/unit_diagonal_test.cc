// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/unit_diagonal.h"

#include <gtest/gtest.h>

#include "models/support/decompositions.h"

namespace octant::test {
namespace unit_diagonal_test {

/// Elements in metres and microseconds.
Eigen::Matrix3d mixed_units() {
  const Eigen::Matrix3d correlations{{1.0, 0.5, -0.2}, {0.5, 1.0, 0.3}, {-0.2, 0.3, 1.0}};
  const Eigen::Vector3d sigma(2.0, 3e-6, 0.05);
  return sigma.asDiagonal() * correlations * sigma.asDiagonal();
}

TEST(UnitDiagonal, IsCorrelationsAndSigmasOfACovariance) {
  const Eigen::Matrix3d C = mixed_units();
  const UnitDiagonal<Eigen::Matrix3d> unit(C);
  EXPECT_TRUE(unit.scale.isApprox(Eigen::Vector3d(2.0, 3e-6, 0.05), 1e-14));
  EXPECT_NEAR(unit.scaled(0, 1), 0.5, 1e-14);
  EXPECT_NEAR(unit.scaled(2, 2), 1.0, 1e-14);
}

TEST(UnitDiagonal, InverseByEigenvectorsIsTheInverse) {
  const Eigen::Matrix3d C = mixed_units();
  const UnitDiagonal<Eigen::Matrix3d> unit(C);
  const SymmetricEigen<Eigen::Matrix3d> eigen(unit.scaled);
  const Eigen::Matrix3d inverse = unit.inverse(eigen.eigenvectors(), eigen.eigenvalues().cwiseInverse());
  const Eigen::Matrix3d identity = unit.inverse_scale.asDiagonal() * (C * inverse) * unit.scale.asDiagonal();
  EXPECT_LT((identity - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(UnitDiagonal, WhatRoundingLeavesBelowZeroIsFinite) {
  Eigen::Matrix3d C = mixed_units();
  C(1, 1) = -1e-30;
  const UnitDiagonal<Eigen::Matrix3d> unit(C, 1e-12);
  EXPECT_DOUBLE_EQ(unit.scale[1], 1e-6);
  EXPECT_TRUE(unit.scaled.allFinite());
}

}  // namespace unit_diagonal_test
}  // namespace octant::test
