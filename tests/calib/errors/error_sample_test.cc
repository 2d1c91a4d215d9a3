// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_sample.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"
#include "tests/calib/internal_covariance.h"

namespace octant::test {
namespace {

// Stretches that are cut from a long drive leave of white errors what the sample foretells.
TEST(ErrorSample, StretchesOfALongDriveLeaveWhatTheyShould) {
  const calib::Problem problem = problem_of(must(simulate(drive_scenario(260.0), 4)));
  const calib::Solution solution = calib::solve(problem);
  const calib::ParameterLayout layout =
      calib::make_layout(problem, solution.state, std::vector<bool>(8, false));
  const calib::Covariance C = internal_covariance(layout, solution);
  const calib::ErrorSample sample =
      calib::error_sample(layout, solution.trajectories, solution.state, C, 1000);
  EXPECT_EQ(sample.chains.size(), 8U);
  EXPECT_NEAR(sample.share * static_cast<double>(solution.statistics.arrivals), 1000.0, 150.0);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr Eigen::Index kDraws = 40;
  const auto draw = [&](Eigen::Index rows) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, kDraws, [&] { return normal(random); }));
  };
  const Eigen::MatrixXd left =
      sample.residuals_of(draw(sample.residual.size()), sample.prior_root * draw(sample.prior_root.cols()));
  const Eigen::RowVectorXd squares = left.colwise().squaredNorm();
  const double mean = squares.mean();
  const double sigma = std::sqrt((squares.array() - mean).square().mean());
  EXPECT_LT(mean, static_cast<double>(sample.residual.size()));
  EXPECT_NEAR(sample.residual.squaredNorm(), mean, 4.5 * sigma);
}

}  // namespace
}  // namespace octant::test
