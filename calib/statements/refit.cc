// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/refit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "calib/adjust/information.h"
#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/errors/error_model.h"
#include "calib/errors/error_sample.h"
#include "calib/errors/statistics.h"
#include "calib/errors/whiteness.h"
#include "models/support/unit_diagonal.h"

namespace octant::calib {
namespace {

/// Loss scale of the first adjustment without an assumption. A false assumption distorts all residuals by
/// tens of sigmas.
constexpr double kCoarseScale = 20.0;
constexpr int kRefitRounds = 5;

AdjustOptions alone(const SolveOptions& options, double scale, double function_tolerance) {
  AdjustOptions adjust;  // each rank by itself: all have the same small data
  adjust.loss = {scale, scale};
  adjust.max_iterations = options.max_iterations;
  adjust.workers.threads = options.threads;
  adjust.function_tolerance = function_tolerance;
  if (options.on_progress) adjust.on_iteration = [&options](int, double) { return !options.is_stopped(); };
  return adjust;
}

/// Number of observations rejected as outliers.
std::size_t left_out_count(const std::vector<Trajectory>& trajectories) {
  std::size_t count = 0;
  for (const Trajectory& t : trajectories) {
    for (const ArrivalObservation& a : t.arrivals) count += is_outlier(a.rejection);
    for (const BearingObservation& b : t.bearings) count += is_outlier(b.rejection);
  }
  return count;
}

void judge_fit(const SolveOptions& options, Fit& fit) {
  const SharedState state = fit.state();
  fit.ok = fit.last.converged;
  fit.cost = fit.last.cost + 0.5 * options.rejection_sigmas * options.rejection_sigmas *
                                 static_cast<double>(left_out_count(fit.trajectories));
  const CalibrationStatistics s =
      statistics_of(fit.problem, fit.layout, fit.trajectories, state, fit.last.cost, options.threads);
  const double squares = 2 * (fit.last.cost - prior_cost(fit.problem, fit.layout, fit.x));
  fit.noise_factor = s.redundancy >= 30 && squares > 0 ? std::sqrt(squares / s.redundancy) : 1.0;
}

bool reject_and_adjust_again(const SolveOptions& options, Fit& fit) {
  for (int round = 0; round < kRefitRounds; ++round) {
    const std::size_t changed =
        reject_outliers(fit.trajectories, fit.state(), options.rejection_sigmas, options.threads);
    if (round > 0 && changed == 0) break;
    fit.last = adjust(fit.problem, fit.layout, fit.trajectories, fit.x, alone(options, 0.0, 1e-10));
    if (fit.last.interrupted || !fit.x.allFinite()) return false;
  }
  return true;
}

/// Trajectories whose arrivals have the noise of a fit.
std::vector<Trajectory> at_noise(const Fit& fit, std::vector<Trajectory> trajectories) {
  for (Trajectory& t : trajectories)
    for (ArrivalObservation& a : t.arrivals) a.sigma_s *= std::max(1e-6, fit.noise_factor);
  return trajectories;
}

/// Covariance for the noise of a fit, without its correlation except for large sites.
Covariance covariance_of(const SolveOptions& options, const Fit& fit) {
  std::vector<Trajectory> trajectories = at_noise(fit, fit.trajectories);
  const Information information =
      information_at(fit.problem, fit.layout, trajectories, fit.x, {.threads = options.threads});
  // The noise of the arrivals does not affect priors, so only the information of the data is reduced.
  const double inflation =
      is_dense(fit.layout) ? 1.0
                           : whiteness_of(fit.trajectories, fit.state(), options.threads).variance_factor();
  return Covariance(inverse_of_information(information.data / inflation + information.prior));
}

}  // namespace

Fit fit_of(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
           const std::vector<Trajectory>& trajectories) {
  Fit fit;
  static_cast<Estimate&>(fit) = estimate;
  fit.problem = without_recordings(problem);
  std::size_t arrivals = 0;
  for (const Trajectory& t : trajectories) arrivals += t.arrivals.size();
  const std::size_t stride = arrivals / kMostArrivals + 1;
  for (const Trajectory& t : trajectories)
    fit.trajectories.push_back(stride == 1 ? t : some_segments(t, stride));
  if (stride > 1) reject_and_adjust_again(options, fit);
  judge_fit(options, fit);
  return fit;
}

void adjust_anew(const SolveOptions& options, Fit& fit) {
  readmit_all(fit.trajectories, fit.beacon_usable);
  fit.ok = false;
  for (const double scale : {kCoarseScale, kCauchyScale}) {
    fit.last = adjust(fit.problem, fit.layout, fit.trajectories, fit.x,
                      alone(options, scale, scale > kCauchyScale ? 1e-4 : 1e-8));
    if (fit.last.interrupted || !fit.x.allFinite()) return;
  }
  if (reject_and_adjust_again(options, fit)) judge_fit(options, fit);
}

Eigen::MatrixXd inverse_of_information(const Eigen::MatrixXd& information, double ridge) {
  UnitDiagonal<Eigen::MatrixXd> unit(information, 1e-12);
  unit.scaled.diagonal().array() += ridge;
  return unit.inverse_scale.asDiagonal() *
         unit.scaled.ldlt().solve(Eigen::MatrixXd::Identity(information.rows(), information.cols())) *
         unit.inverse_scale.asDiagonal();
}

HonestCovariance honest_covariance(const SolveOptions& options, const Fit& fit) {
  const Covariance C = covariance_of(options, fit);
  const ErrorModel errors = is_dense(fit.layout) ? error_model_of(fit.layout, at_noise(fit, fit.trajectories),
                                                                  fit.state(), C, 1.0, options.threads)
                                                 : ErrorModel{};
  if (errors.correlated) return {errors.covariance, errors.freedoms};
  return {*C.matrix()};
}

double noise_variance(const Fit& fit, int threads) {
  return std::max(1e-12, fit.noise_factor * fit.noise_factor) *
         whiteness_of(fit.trajectories, fit.state(), threads).variance_factor();
}

double variance_of_error(const SolveOptions& options, const Fit& fit,
                         const std::vector<Trajectory>& with_error) {
  if (!is_dense(fit.layout)) return noise_variance(fit, options.threads);
  const SharedState state = fit.state();
  const Covariance C = covariance_of(options, fit);
  const auto sample_of = [&](const std::vector<Trajectory>& trajectories) {
    return error_sample(fit.layout, at_noise(fit, trajectories), state, C, kMostRows);
  };
  ErrorSample sample = sample_of(fit.trajectories);
  sample.pattern = sample_of(with_error).residual - sample.residual;
  return std::max(1e-12, fit.noise_factor * fit.noise_factor) *
         error_model_of(sample, options.threads).pattern_variance;
}

}  // namespace octant::calib
