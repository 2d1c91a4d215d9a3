// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/pose_equations.h"

#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace octant {
namespace pose_equations_test {

TEST(PoseEquations, StepIsTheWeightedLeastSquaresSolution) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (const bool has_offset : {false, true}) {
    const int n = has_offset ? 4 : 3;
    PoseEquations equations;
    Eigen::MatrixXd J(12, 4);
    Eigen::VectorXd r(12), w(12);
    for (Eigen::Index i = 0; i < 12; ++i) {
      const double row[4] = {normal(random), normal(random), normal(random), 1.0};
      J.row(i) << row[0], row[1], row[2], row[3];
      r[i] = normal(random);
      w[i] = 1e6 * (1.0 + normal(random) * normal(random));
      equations.add(w[i], row, r[i], has_offset);
    }
    const Eigen::MatrixXd A = J.leftCols(n);
    const Eigen::VectorXd expected =
        (A.transpose() * w.asDiagonal() * A).inverse() * (A.transpose() * w.asDiagonal() * r);
    // Regularisation of an unobserved direction: 1e-7 of this information.
    EXPECT_LT((equations.step(10.0, has_offset).head(n) - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(PoseEquations, WhatNothingTellsStaysWhereItIs) {
  PoseEquations equations;
  equations.add(1e6, {1.0, 0.0, 0.0, 0.0}, 0.5, false);
  const Eigen::Vector4d step = equations.step(10.0, false);
  EXPECT_NEAR(step[0], 0.5, 1e-6);
  EXPECT_EQ(step[1], 0.0);
  EXPECT_EQ(step[2], 0.0);
}

}  // namespace pose_equations_test
}  // namespace octant
