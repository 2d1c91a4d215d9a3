// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/refit.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"

namespace octant::test {
namespace refit_test {

RC_GTEST_PROP(InverseOfInformation, IsTheInverseInAnyUnits, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const int n = *rc::gen::inRange(1, 12);
  Eigen::MatrixXd A(n + 2, n);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = draws.normal();
  Eigen::VectorXd scale(n);
  for (double& s : scale) s = std::pow(10.0, draws.uniform(-3, 4));
  const Eigen::MatrixXd N = A.transpose() * A + 0.01 * Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd C = calib::inverse_of_information(scale.asDiagonal() * N * scale.asDiagonal());
  const Eigen::MatrixXd want = N.fullPivLu().inverse();
  // Condition below some 1e4; the floor of 1e-12 of a unit diagonal is far below that.
  RC_ASSERT((scale.asDiagonal() * C * scale.asDiagonal() - want).cwiseAbs().maxCoeff() <
            1e-7 * want.cwiseAbs().maxCoeff());
}

TEST(InverseOfInformation, OfADirectionWithoutInformationIsWideAndANumber) {
  Eigen::MatrixXd N(3, 3);  // parameters 0 and 1 are seen by their difference alone
  N << 4, -4, 0, -4, 4, 0, 0, 0, 9;
  const Eigen::MatrixXd C = calib::inverse_of_information(N);
  EXPECT_TRUE(C.allFinite());
  EXPECT_NEAR(C(2, 2), 1.0 / 9, 1e-10);
  EXPECT_GT(C(0, 0), 1e10 / 4) << "each by itself is unknown";
  EXPECT_EQ(calib::inverse_of_information(Eigen::MatrixXd::Zero(2, 2)).allFinite(), true);
}

TEST(InverseOfInformation, OfNothingIsEmpty) {
  EXPECT_EQ(calib::inverse_of_information(Eigen::MatrixXd(0, 0)).size(), 0);
}

}  // namespace refit_test
}  // namespace octant::test
