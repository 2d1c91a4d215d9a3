// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "calib/start/approach.h"

namespace octant::calib {

/// One adjustment of the same arrivals under other assumptions. Its noise factor is relative to the noise
/// that all fits of a comparison share.
struct Fit : Estimate {
  bool ok = false;                       ///< converged
  Problem problem;                       ///< site under these assumptions, without recordings
  std::vector<Trajectory> trajectories;  ///< solved at x, outliers rejected
  /// Half the sum of squares of all residuals and priors at that noise. Each rejected arrival counts with its
  /// squares at the rejection limit. A lower cost explains more.
  double cost = 0.0;
};

/// Converts the estimate of a calibration to a fit. From long logs, an evenly spread part with about
/// kMostArrivals arrivals is adjusted again.
[[nodiscard]] Fit fit_of(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                         const std::vector<Trajectory>& trajectories);
inline constexpr std::size_t kMostArrivals = 20'000;

/// Adjusts again, starting from `fit`: all arrivals admitted, Cauchy's loss from coarse to fine, then least
/// squares of those that agree. The layout's size may differ from that of x.
/// @param fit  input: problem, layout, x and trajectories
void adjust_anew(const SolveOptions& options, Fit& fit);

/// Inverse of an information matrix, scaled to a unit diagonal first.
/// @param ridge  added to the scaled diagonal; a direction without information gets its inverse as variance
[[nodiscard]] Eigen::MatrixXd inverse_of_information(const Eigen::MatrixXd& information,
                                                     double ridge = 1e-12);

/// Joint covariance of the parameters in internal units under the error model of the fit's residuals
/// (error_model.h). All tests of assumptions use it.
struct HonestCovariance {
  Eigen::MatrixXd matrix;
  double freedoms = INFINITY;  ///< degrees of freedom of its variances
};
[[nodiscard]] HonestCovariance honest_covariance(const SolveOptions& options, const Fit& fit);

/// Variance of the arrivals of a fit in units of their sigmas, enlarged by the correlation within pairs.
[[nodiscard]] double noise_variance(const Fit& fit, int threads);

/// Variance of the size of an error under the error model of the fit's residuals, relative to white noise
/// with the sigmas of the arrivals. A difference of costs divided by it is a difference of log-likelihoods.
/// @param with_error  trajectories of the fit with the error
[[nodiscard]] double variance_of_error(const SolveOptions& options, const Fit& fit,
                                       const std::vector<Trajectory>& with_error);

}  // namespace octant::calib
