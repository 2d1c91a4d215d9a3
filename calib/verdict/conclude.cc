// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/conclude.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/errors/reliability.h"
#include "calib/errors/statistics.h"
#include "calib/problem/ranges.h"
#include "calib/verdict/datum.h"
#include "calib/verdict/observability.h"
#include "calib/verdict/shadows.h"

namespace octant::calib {
namespace {

/// Computes sigmas that account for correlated errors, by the residuals.
void allow_for_correlation(const Estimate& estimate, const Covariance& C,
                           const std::vector<Trajectory>& trajectories, double share_of_log, int threads,
                           Solution& solution) {
  solution.errors = error_model_of(estimate.layout, trajectories, solution.state, C, share_of_log, threads);
  if (!solution.errors.correlated || solution.covariance.parameters.empty()) return;
  solution.white_covariance = solution.covariance;
  const Eigen::VectorXd si = estimate.layout.si_per_unit();
  solution.covariance.matrix = si.asDiagonal() * solution.errors.covariance * si.asDiagonal();
}

/// Enlarges the sigmas for beacons that may have been shadowed at a stop.
/// @return warning, or an empty text
std::string allow_for_shadows(const Problem& problem, const Estimate& estimate, const Covariance& C,
                              const std::vector<Trajectory>& trajectories, Solution& solution) {
  constexpr double kWorthTelling = 1.5;  // growth of a sigma
  if (solution.covariance.parameters.empty()) return "";
  const ShadowRisk risk = shadow_risk(trajectories, solution.state, {estimate.layout, C});
  if (risk.covariance.size() == 0) return "";
  const Eigen::VectorXd si = estimate.layout.si_per_unit();
  const Eigen::VectorXd before = solution.covariance.matrix.diagonal();
  solution.covariance.matrix += si.asDiagonal() * risk.covariance * si.asDiagonal();
  std::vector<std::string> grown;
  for (std::size_t b = 0; b < problem.site.beacons.size(); ++b)
    if (std::ranges::any_of(estimate.layout.beacon[b], [&](int column) {
          return column >= 0 &&
                 solution.covariance.matrix(column, column) > kWorthTelling * kWorthTelling * before[column];
        }))
      grown.push_back(problem.site.beacons[b].name);
  if (grown.empty()) return "";
  return fmt::format(
      "{:.2g} % of the beacons received at stops came late at all receivers; at stops with few beacons such "
      "echoes show in no residual, and the sigmas of {} allow for that: record more stops there",
      100 * risk.share, fmt::join(grown, ", "));
}

SolveStatus status_of(const AdjustResult& last) {
  return last.converged ? SolveStatus::kConverged : SolveStatus::kNotConverged;
}

std::string message_of(const AdjustResult& last) {
  return last.converged ? "converged" : "the adjustment did not converge: " + last.message;
}

/// Computes covariance and verdict again with other weights of the observations, and no other results.
void judge_anew(const Problem& problem, const SolveOptions& options, Estimate estimate,
                std::vector<Trajectory>& trajectories, Solution& solution) {
  solution.status = status_of(estimate.last);
  solution.message = message_of(estimate.last);
  solution.covariance = {};
  solution.marginals = {};
  solution.beacon_status.clear();
  solution.weak.clear();
  solution.undetermined.clear();
  estimate.last.data.reset();  // belongs to the subsampled log
  static_cast<void>(judge(problem, options, estimate, trajectories, solution));
}

/// Fit, covariance and verdict of the given trajectories.
std::string conclude_as_is(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                           Findings findings, bool is_subsampled, Solution& solution) {
  const AdjustResult& last = estimate.last;
  std::vector<Trajectory>& trajectories = solution.trajectories;
  solution.state = estimate.state();
  solution.final_cost = last.cost;
  solution.tof_sigma_s = problem.site.noise.tof_sigma_s * estimate.noise_factor;
  solution.statistics = findings.statistics;
  solution.statistics.converged = last.converged;
  // The factor is relative to the noise in the site file, not to the estimated noise.
  solution.statistics.variance_factor *= estimate.noise_factor * estimate.noise_factor;
  solution.statistics.chi2_p = chi_square_p(
      solution.statistics.variance_factor * solution.statistics.redundancy, solution.statistics.redundancy);
  solution.status = status_of(last);
  solution.message = message_of(last);
  solution.datum = datum_of(problem);
  const std::size_t judged_from = solution.warnings.size();
  // Parameters that the data do not determine often prevent convergence. They are then the finding.
  const Covariance C = judge(problem, options, estimate, trajectories, solution);
  if (is_subsampled) solution.warnings.resize(judged_from);  // the verdict of the whole log has its own
  solution.reliability = reliability_of(problem, estimate.layout, trajectories, solution.state, C,
                                        solution.beacon_status, estimate.noise_factor, options.threads,
                                        kAllEpochs, findings.totals ? &*findings.totals : nullptr);
  const double share_of_log = findings.totals ? 1.0 / static_cast<double>(findings.totals->stride) : 1.0;
  allow_for_correlation(estimate, C, trajectories, share_of_log, options.threads, solution);
  solution.left_out = std::move(findings.left_out.arrivals);
  solution.left_out_bearings = std::move(findings.left_out.bearings);
  solution.left_out_poses = std::move(findings.left_out.poses);
  solution.beacon_mirrored = estimate.beacon_mirrored;
  for (std::string& warning : bearings_in_doubt(problem, solution.left_out_bearings))
    solution.warnings.push_back(std::move(warning));
  const bool is_whole = !is_subsampled && (!findings.totals || findings.totals->stride == 1);
  solution.totals = std::move(findings.totals);
  solution.warnings.insert(solution.warnings.end(), findings.flips.begin(), findings.flips.end());
  return is_whole ? allow_for_shadows(problem, estimate, C, trajectories, solution) : "";
}

}  // namespace

std::string conclude(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                     Findings findings, Solution& solution) {
  solution.trajectories = std::move(findings.trajectories);
  std::vector<Trajectory> as_complete = std::move(findings.as_complete);
  std::string shadowed =
      conclude_as_is(problem, options, estimate, std::move(findings), !as_complete.empty(), solution);
  if (!as_complete.empty()) judge_anew(problem, options, estimate, as_complete, solution);
  return shadowed;
}

}  // namespace octant::calib
