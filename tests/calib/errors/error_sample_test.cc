// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_sample.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

#include "calib/errors/error_draws.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/internal_covariance.h"

namespace octant::test {
namespace error_sample_test {

std::ptrdiff_t chains_of(const calib::ErrorSample& sample) {
  const auto& links = sample.chains.links;
  return std::count_if(links.begin(), links.end(), [](const auto& link) { return link.next_size == 0; });
}

// Segments of a long drive absorb white errors as the sample predicts.
TEST(ErrorSample, StretchesOfALongDriveLeaveWhatTheyShould) {
  const calib::Problem problem = problem_of(must(simulate(drive_scenario(260.0), 4)));
  const calib::Solution solution = calib::solve(problem);
  const calib::ParameterLayout layout = calib::make_layout(problem, solution.state);
  const calib::Covariance C = internal_covariance(layout, solution);
  const calib::ErrorSample sample =
      calib::error_sample(layout, solution.trajectories, solution.state, C, 1000);
  EXPECT_EQ(chains_of(sample), 8);
  EXPECT_NEAR(sample.share * static_cast<double>(solution.statistics.arrivals), 1000.0, 150.0);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const calib::ErrorDraws draws(sample);
  calib::ErrorDraws::Scratch scratch;
  std::array<double, 3 * calib::kDrawsAbreast> of_draw{};
  for (std::size_t panel = 0; panel < 3; ++panel) {
    std::vector<calib::DrawLine> errors(sample.rows.size());
    for (calib::DrawLine& line : errors)
      for (float& e : line.of) e = static_cast<float>(normal(random));
    draws.adjust(errors, draws.of_priors(panel), scratch);
    calib::add_squares(errors.data(), errors.size(), of_draw.data() + panel * calib::kDrawsAbreast);
  }
  const Eigen::Map<const Eigen::RowVectorXd> squares(of_draw.data(), of_draw.size());
  const double mean = squares.mean();
  const double sigma = std::sqrt((squares.array() - mean).square().mean());
  EXPECT_LT(mean, static_cast<double>(sample.residual.size()));
  EXPECT_NEAR(sample.residual.squaredNorm(), mean, 4.5 * sigma);
}

}  // namespace error_sample_test
}  // namespace octant::test
