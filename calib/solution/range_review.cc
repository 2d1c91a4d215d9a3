// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/solution/range_review.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calib/adjust/priors.h"

namespace octant::calib {
namespace {

constexpr double kOutlierRange = 4.0;
/// Ratio of the sigmas that are compared.
constexpr double kSigmaStep = 1.5;

/// Covariance of the computed times of flight [s^2].
Eigen::MatrixXd computed_covariance(const Problem& problem, const SharedState& state,
                                    const JointCovariance& covariance) {
  const std::vector<BeaconRange>& pairs = problem.beacon_ranges.pairs;
  Eigen::MatrixXd jacobian =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(pairs.size()), covariance.matrix.rows());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    for (const auto& [id, value] : range_derivatives(problem, state, pairs[k])) {
      int column = covariance.index_of(id);
      if (column < 0 && id == parameters::speed(pairs[k].run + 1))
        column = covariance.index_of(parameters::speed());
      if (column >= 0) jacobian(static_cast<Eigen::Index>(k), column) += value;
    }
  return jacobian * covariance.matrix * jacobian.transpose();
}

/// Sigma of the delays at which the deviations are most likely.
double likely_delay_sigma_s(const BeaconRanges& ranges, const Eigen::VectorXd& residuals_s,
                            const Eigen::MatrixXd& computed, double least_s, double most_s) {
  double best_s = least_s, best = -INFINITY;
  for (double sigma_s = least_s; sigma_s <= std::max(least_s, most_s); sigma_s *= kSigmaStep) {
    const Eigen::LLT<Eigen::MatrixXd> factor(ranges.covariance(sigma_s) + computed);
    const double likelihood = -0.5 * factor.matrixL().solve(residuals_s).squaredNorm() -
                              Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum();
    if (likelihood > best) {
      best = likelihood;
      best_s = sigma_s;
    }
  }
  return best_s;
}

std::string range_in_words(const Site& site, const BeaconRange& range, double residual_s) {
  return fmt::format(
      "The ranges between the beacons {} and {} ({} rows) deviate by {:.2f} m from the others and are left "
      "out: the direct path may be blocked.",
      site.beacons[range.from.index()].name, site.beacons[range.to.index()].name, range.used + range.left_out,
      -residual_s * range.model_speed_mps / site.timing.legs());
}

}  // namespace

std::vector<std::string> review_ranges(Problem& problem, const SharedState& state,
                                       const JointCovariance& covariance) {
  BeaconRanges& ranges = problem.beacon_ranges;
  const double least_s =
      std::hypot(problem.site.noise.tof_sigma_s, problem.site.noise.pair_sigma_s.value_or(0.0));
  std::vector<std::string> words;
  while (!ranges.pairs.empty()) {
    const Eigen::VectorXd residuals_s = range_residuals_s(problem, state);
    const Eigen::MatrixXd computed = computed_covariance(problem, state, covariance);
    ranges.set_delay_sigma(
        likely_delay_sigma_s(ranges, residuals_s, computed, least_s, largest_delay_sigma_s(problem.site)));
    // Deviation of each range from what the others and the adjustment predict, in sigmas.
    const Eigen::LLT<Eigen::MatrixXd> factor(ranges.covariance(ranges.delay_sigma_s) + computed);
    const Eigen::MatrixXd weight = factor.solve(Eigen::MatrixXd::Identity(computed.rows(), computed.cols()));
    const Eigen::ArrayXd deviation = (weight * residuals_s).array() / weight.diagonal().array().sqrt();
    Eigen::Index worst = 0;
    if (deviation.abs().maxCoeff(&worst) < kOutlierRange) break;
    const auto at = ranges.pairs.begin() + worst;
    words.push_back(range_in_words(problem.site, *at, residuals_s[worst]));
    ranges.pairs.erase(at);
    ranges.set_delay_sigma(ranges.delay_sigma_s);
  }
  return words;
}

}  // namespace octant::calib
