// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/visit_information.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/simulator/random.h"

namespace octant::calib {
namespace visit_information_test {

constexpr double kHalfWidth = 0.25;  ///< width of the transition, logarithm of the ratio of variances

/// A covariance whose variances are `level` times the unit in the mean.
Eigen::MatrixXd covariance_at(double level, std::uint64_t seed) {
  Random draws(seed, 1);
  Eigen::MatrixXd A(5, 8);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = draws.normal();
  const Eigen::MatrixXd C = A * A.transpose();
  return level * 5 / C.trace() * C;
}

/// As much of the shown model as a ratio takes.
double share_at(double log_ratio) {
  const Eigen::MatrixXd white = Eigen::MatrixXd::Identity(5, 5), stated = covariance_at(3.0, 1),
                        shown = covariance_at(3.0 * std::exp(log_ratio), 2);
  const Eigen::MatrixXd mixed = between_error_models(white, stated, shown), way = shown - stated;
  const double share = (mixed - stated).cwiseProduct(way).sum() / way.squaredNorm();
  EXPECT_LT((mixed - stated - share * way).norm(), 1e-12 * stated.norm()) << "not on the line between both";
  return share;
}

TEST(BetweenErrorModels, TheLargerOneCountsAlone) {
  for (const double ratio : {1.01 * kHalfWidth, 0.5, 2.0}) {
    EXPECT_DOUBLE_EQ(share_at(ratio), 1.0) << ratio;
    EXPECT_NEAR(share_at(-ratio), 0.0, 1e-15) << ratio;
  }
}

TEST(BetweenErrorModels, WhereBothAreAboutAsLargeTheRatioMixesThem) {
  EXPECT_NEAR(share_at(0.0), 0.5, 1e-12);
  constexpr int kSteps = 100;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double ratio = kHalfWidth * k / kSteps;
    EXPECT_NEAR(share_at(ratio), 0.5 * (1.0 + ratio / kHalfWidth), 1e-9) << ratio;
  }
}

/// Ratios are relative to white variances, so different units (metres, seconds) do not affect the result.
TEST(BetweenErrorModels, UnitsDoNotMatter) {
  Eigen::VectorXd unit(5);
  unit << 1e-3, 1.0, 1e-6, 30.0, 1e4;
  const Eigen::MatrixXd white = covariance_at(1.0, 3), stated = covariance_at(2.0, 4),
                        shown = covariance_at(2.2, 5);
  const auto in_units = [&](const Eigen::MatrixXd& C) -> Eigen::MatrixXd {
    return unit.asDiagonal() * C * unit.asDiagonal();
  };
  const Eigen::MatrixXd there = in_units(between_error_models(white, stated, shown)),
                        here = between_error_models(in_units(white), in_units(stated), in_units(shown));
  EXPECT_LT((unit.cwiseInverse().asDiagonal() * (there - here) * unit.cwiseInverse().asDiagonal()).norm(),
            1e-12);
}

}  // namespace visit_information_test
}  // namespace octant::calib
