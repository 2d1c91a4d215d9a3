// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Ranges between beacons as rows of the adjustment, and their review.
#include "calib/solution/range_review.h"

#include <cmath>

#include <gmock/gmock.h>

#include "calib/adjust/priors.h"
#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace range_review_test {

constexpr double kNoise_s = 1e-5;

/// True times of flight between all beacons of the hall, with an own delay of each beacon.
std::vector<BeaconFlight> flights_of(const Site& site, const SharedState& truth, double delay_sigma_s) {
  Random draws(11);
  std::vector<double> delay_s;
  for (std::size_t b = 0; b < site.beacons.size(); ++b) delay_s.push_back(delay_sigma_s * draws.normal());
  std::vector<BeaconFlight> flights;
  for (std::size_t a = 0; a < site.beacons.size(); ++a)
    for (std::size_t b = a + 1; b < site.beacons.size(); ++b)
      flights.push_back({0.0, BeaconId(a), BeaconId(b),
                         (truth.beacon_p_map_m[a] - truth.beacon_p_map_m[b]).norm() / speed_mps(site.medium) +
                             site.timing.delay_s + delay_s[a] + delay_s[b] + kNoise_s * draws.normal()});
  return flights;
}

calib::Problem ranged_hall(double delay_sigma_s) {
  calib::Problem problem;
  problem.site = hall_scenario().site;
  problem.site.noise.tof_sigma_s = kNoise_s;
  problem.runs.resize(1);
  problem.beacon_ranges =
      beacon_ranges(problem.site, flights_of(problem.site, prior_state(problem.site), delay_sigma_s));
  return problem;
}

TEST(RangeReview, RowsHaveTheNumericDerivative) {
  const calib::Problem problem = ranged_hall(0.0);
  const calib::ParameterLayout layout = calib::make_layout(problem, prior_state(problem.site));
  Random draws(2);
  Eigen::VectorXd x = layout.vector_of(layout.fixed);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += 0.05 * draws.normal();
  const auto first = static_cast<std::size_t>(layout.size());
  const auto residuals = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    const std::vector<calib::PriorRow> rows = calib::prior_rows(problem, layout, at);
    Eigen::VectorXd r(static_cast<Eigen::Index>(rows.size() - first));
    for (std::size_t k = first; k < rows.size(); ++k)
      r[static_cast<Eigen::Index>(k - first)] = rows[k].residual;
    return r;
  };
  const std::vector<calib::PriorRow> rows = calib::prior_rows(problem, layout, x);
  ASSERT_EQ(rows.size(), first + problem.beacon_ranges.pairs.size());
  Eigen::MatrixXd here = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size() - first), layout.size());
  for (std::size_t k = first; k < rows.size(); ++k)
    for (const auto& [column, value] : rows[k].entries)
      here(static_cast<Eigen::Index>(k - first), column) += value;
  // Derivatives are about 1 / (343 m/s 1e-5 s) = 300 per metre.
  EXPECT_LT((here - numeric_jacobian(residuals, x, 1e-5)).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(RangeReview, EstimatesTheSigmaOfTheDelays) {
  for (const double delay_s : {0.0, 1e-4}) {
    calib::Problem problem = ranged_hall(delay_s);
    problem.site.timing.delay_sigma_s = 3e-4;
    EXPECT_TRUE(calib::review_ranges(problem, prior_state(problem.site), {}).empty());
    EXPECT_NEAR(std::log(problem.beacon_ranges.delay_sigma_s / std::max(delay_s, kNoise_s)), 0.0,
                std::log(2.0));
  }
}

/// Deviations that the uncertainty of the computed times explains show no delays and no blunders.
TEST(RangeReview, AllowsForTheUncertaintyOfTheAdjustment) {
  calib::Problem problem = ranged_hall(0.0);
  problem.site.timing.delay_sigma_s = 3e-4;
  JointCovariance covariance;
  SharedState state = prior_state(problem.site);
  Random draws(4);
  for (std::size_t b = 0; b < problem.site.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i) {
      covariance.parameters.push_back(parameters::beacon_position(b, i));
      state.beacon_p_map_m[b][static_cast<int>(i)] += 0.1 * draws.normal();
    }
  const auto n = static_cast<Eigen::Index>(covariance.parameters.size());
  covariance.matrix = 0.01 * Eigen::MatrixXd::Identity(n, n);
  EXPECT_TRUE(calib::review_ranges(problem, state, covariance).empty());
  EXPECT_LT(problem.beacon_ranges.delay_sigma_s, 3e-5);
  calib::Problem exact = ranged_hall(0.0);
  exact.site.timing.delay_sigma_s = 3e-4;
  static_cast<void>(calib::review_ranges(exact, state, {}));
  EXPECT_GT(exact.beacon_ranges.delay_sigma_s, 1e-4);
}

TEST(RangeReview, LeavesOutABlockedRange) {
  calib::Problem problem = ranged_hall(2e-5);
  problem.beacon_ranges.pairs[3].tof_s += 3e-3;
  const std::vector<std::string> words = calib::review_ranges(problem, prior_state(problem.site), {});
  ASSERT_EQ(words.size(), 1U);
  EXPECT_THAT(words[0], testing::HasSubstr("deviate by 1.0"));
  EXPECT_EQ(problem.beacon_ranges.pairs.size(), 27U);
}

/// Beacons of a drive that have weak priors: ranges between them improve the result.
TEST(RangeReview, RangesBetweenBeaconsImproveACalibration) {
  Scenario scenario = hall_scenario();
  scenario.path.epochs = 12;
  scenario.true_temperature_offset_degC = 0.0;
  const World world = must(simulate(scenario, 3));
  SharedState truth = prior_state(world.site);
  for (std::size_t b = 0; b < world.truth.beacons.size(); ++b)
    truth.beacon_p_map_m[b] = world.truth.beacons[b].position_m;
  Site site = world.site;
  const auto without = calib::calibrate(site, {world.run});
  calib::CalibrationOptions options;
  options.beacon_flights = flights_of(site, truth, 0.0);
  const auto with = calib::calibrate(site, {world.run}, options);
  ASSERT_TRUE(without && with);
  ASSERT_EQ(with->solution.status, calib::SolveStatus::kConverged);
  double sum_without = 0.0, sum_with = 0.0;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto id = parameters::beacon_position(b, i);
      const int at = without->solution.covariance.index_of(id), in = with->solution.covariance.index_of(id);
      if (at < 0 || in < 0) continue;
      sum_without += without->solution.covariance.matrix(at, at);
      sum_with += with->solution.covariance.matrix(in, in);
    }
  EXPECT_LT(sum_with, 0.9 * sum_without);
}

}  // namespace range_review_test
}  // namespace octant::test
