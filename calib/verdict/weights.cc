// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/weights.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/problem/ranges.h"

namespace octant::calib {
namespace {

/// Sigma of an estimate, as a share of its prior, above which the weight of the prior matters: an optimal
/// estimate differs by less than a quarter of its variance below.
constexpr double kPriorMatters = 0.5;
/// Share of the information on a parameter that must come from the arrivals to determine their growth.
constexpr double kLeastFromArrivals = 0.1;

/// The biases of pairs have variances, but are errors of the arrivals.
bool is_prior(const Parameter& p) {
  return std::isfinite(p.prior_sigma) && p.id.kind != ParameterKind::kPairBias;
}

/// Inverse variances of the priors [1 / SI^2]; zero for parameters without one.
Eigen::VectorXd prior_information(const ParameterLayout& layout) {
  Eigen::VectorXd information = Eigen::VectorXd::Zero(layout.size());
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameter(i);
    if (is_prior(p)) information[i] = std::pow(p.prior_sigma * p.si_per_unit, -2);
  }
  return information;
}

/// Sum of the logarithms of the variances of beacons, delays and speed, for which a site is calibrated.
double log_variances_of_site(const ParameterLayout& layout, const Solution& solution) {
  double sum = 0.0;
  for (int i = 0; i < layout.size(); ++i) {
    const ParameterKind kind = layout.parameter(i).id.kind;
    if (kind == ParameterKind::kBeaconPosition || kind == ParameterKind::kBeaconDelay ||
        kind == ParameterKind::kSiteDelay || kind == ParameterKind::kSpeed)
      sum += std::log(solution.covariance.matrix(i, i));
  }
  return sum;
}

}  // namespace

double growth_against_priors(const ParameterLayout& layout, const Solution& solution) {
  const Eigen::MatrixXd &honest = solution.covariance.matrix, &white = solution.white_covariance.matrix;
  if (!solution.errors.correlated || white.rows() != layout.size()) return 1.0;
  const Eigen::VectorXd prior = prior_information(layout);
  std::vector<double> growth;
  for (int i = 0; i < layout.size(); ++i) {
    const double all = 1.0 / white(i, i), of_arrivals = all - prior[i];
    if (honest(i, i) * prior[i] > kPriorMatters * kPriorMatters && of_arrivals > kLeastFromArrivals * all)
      growth.push_back(std::sqrt(std::max(1.0, (honest(i, i) * all * all - prior[i]) / of_arrivals)));
  }
  return growth.empty() ? 1.0 : median(std::move(growth));
}

Estimate with_weighted_priors(Estimate estimate, double growth) {
  for (Parameter& p : estimate.layout.parameters)
    if (is_prior(p)) p.prior_sigma /= growth;
  estimate.last.data.reset();
  return estimate;
}

void adopt_if_better(const ParameterLayout& layout, double growth, Solution weighted, Solution& solution) {
  // With Q = (H + g^2 P)^-1, the priors contribute g^4 Q P Q to the covariance of the estimate, of which
  // g^2 Q P Q is part of Q.
  const bool is_white = weighted.white_covariance.parameters.empty();
  const Eigen::MatrixXd Q = is_white ? weighted.covariance.matrix : weighted.white_covariance.matrix;
  if (Q.rows() != layout.size()) return;
  const double growth2 = growth * growth;
  weighted.covariance.matrix +=
      growth2 * (growth2 - 1.0) * Q * prior_information(layout).asDiagonal() * Q.transpose();
  if (!(log_variances_of_site(layout, weighted) < log_variances_of_site(layout, solution))) return;
  solution.trajectories = std::move(weighted.trajectories);
  solution.state = std::move(weighted.state);
  solution.left_out = std::move(weighted.left_out);
  solution.left_out_bearings = std::move(weighted.left_out_bearings);
  solution.left_out_poses = std::move(weighted.left_out_poses);
  solution.reliability = std::move(weighted.reliability);
  solution.totals = std::move(weighted.totals);
  solution.errors = std::move(weighted.errors);
  solution.covariance = std::move(weighted.covariance);
}

}  // namespace octant::calib
