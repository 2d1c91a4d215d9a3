// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/non_negative.h"

#include <gtest/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace non_negative_test {

TEST(NonNegative, LeastSquaresKeepTheirConditions) {
  Random random(5);
  for (int round = 0; round < 50; ++round) {
    const Eigen::Index m = 12, n = 1 + round % 9;
    Eigen::MatrixXd A(m, n);
    Eigen::VectorXd b(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) A(i, j) = random.normal();
      b[i] = random.normal();
    }
    const Eigen::VectorXd x = calib::non_negative_least_squares(A, b);
    const Eigen::VectorXd w =
        A.transpose() * (b - A * x);  // Karush, Kuhn and Tucker: w <= 0, and = 0 where x > 0
    for (Eigen::Index j = 0; j < n; ++j) {
      EXPECT_GE(x[j], 0.0);
      EXPECT_LT(w[j], 1e-8);
      if (x[j] > 0) EXPECT_NEAR(w[j], 0.0, 1e-8);
    }
  }
}

}  // namespace non_negative_test
}  // namespace octant::test
