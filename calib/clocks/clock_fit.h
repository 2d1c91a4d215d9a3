// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/clocks/clock_problem.h"

namespace octant::calib {

/// An adjusted problem.
struct ClockFit {
  Eigen::VectorXd x;
  bool converged = false;
  int iterations = 0;
  double cost = 0.0;          ///< half the sum of squares, robust for receptions
  double noise_factor = 1.0;  ///< noise of the receptions relative to the stated one
  double redundancy = 0.0, variance_factor = 0.0;
  std::size_t used = 0, rejected = 0, unknowns = 0;
};

/// Adjusts by Levenberg-Marquardt on sparse normal equations.
/// @param scale  of Cauchy's loss for receptions, in sigmas; 0: squares
[[nodiscard]] ClockFit adjust_clocks(const ClockProblem& problem, Eigen::VectorXd x, double scale,
                                     int most_iterations = 60);

/// Adjusts with the noise as found, and without receptions beyond `rejection` sigmas, which are marked.
[[nodiscard]] ClockFit adjust_and_reject(ClockProblem& problem, Eigen::VectorXd x, double rejection);

/// Robust sigma of the residuals of the receptions, relative to the noise of the problem.
[[nodiscard]] double robust_sigma(const ClockProblem& problem, const Eigen::VectorXd& x);

/// Covariance of elements of x, scaled by the noise as found; zero for fixed ones. Empty if singular.
[[nodiscard]] Eigen::MatrixXd covariance_of(const ClockProblem& problem, const ClockFit& fit,
                                            const std::vector<int>& elements);

/// Solution of many starts.
struct ClockStart {
  Eigen::VectorXd x;       ///< of the problem of the start
  double cost = INFINITY;  ///< robust
  int starts = 0, agreeing = 0;
  /// Cost above the best, and largest displacement of a beacon [m], of the best solution elsewhere.
  std::optional<double> rival_cost, rival_m;
};

/// Solves a problem from several starts: the prior means, then random positions of what is unknown. The best
/// solution is no proof: another one may exist.
/// @param proceed  false ends the search
[[nodiscard]] ClockStart start_clocks(const ClockProblem& problem, const std::function<bool(int)>& proceed);

/// Values of a complete problem from the solution of its start.
[[nodiscard]] Eigen::VectorXd continued(const ClockProblem& start, const Eigen::VectorXd& x,
                                        const ClockProblem& complete);

}  // namespace octant::calib
