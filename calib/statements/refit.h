// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/start/approach.h"

namespace octant::calib {

/// One adjustment under a hypothesis on what was stated: the same arrivals, other statements believed. Its
/// noise factor is over the noise that all fits of a comparison share.
struct Fit : Estimate {
  bool ok = false;                       ///< converged
  Problem problem;                       ///< site as believed, no recordings
  std::vector<Trajectory> trajectories;  ///< solved at x, outliers rejected
  /// 1/2 the squares of everything at that noise, each arrival left out
  /// counted with the squares at which it would have been: lower explains more.
  double cost = 0.0;
};

/// The estimate of a calibration as a fit. Of long logs an evenly spread part (of all of their arrivals some
/// kMostArrivals), adjusted again on its own.
[[nodiscard]] Fit fit_of(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                         const std::vector<Trajectory>& trajectories);
inline constexpr std::size_t kMostArrivals = 60'000;

/// Adjusts again from where `fit` stands: all arrivals admitted, Cauchy's loss from coarse to fine, then
/// plain squares on those that agree. The layout's size may differ from that of the fit's x.
/// @param fit  problem, layout, x and trajectories are the start
void adjust_anew(const SolveOptions& options, Fit& fit);

/// Inverse of an information matrix, scaled to a unit diagonal first.
/// @param ridge  added to the scaled diagonal: a direction without information gets its inverse as variance
[[nodiscard]] Eigen::MatrixXd inverse_of_information(const Eigen::MatrixXd& information,
                                                     double ridge = 1e-12);

/// Joint covariance of a fit's parameters in internal units under the errors as its residuals show them
/// (noise, and how long it keeps). Everything that tests a statement takes it from here.
[[nodiscard]] Eigen::MatrixXd honest_covariance(const SolveOptions& options, const Fit& fit);
/// What the variances of white noise as found are to be multiplied by where errors keep within a pair.
[[nodiscard]] double variance_inflation(const Fit& fit, int threads);

}  // namespace octant::calib
