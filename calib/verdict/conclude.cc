// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/conclude.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/errors/reliability.h"
#include "calib/errors/statistics.h"
#include "calib/errors/whiteness.h"
#include "calib/problem/clock_check.h"
#include "calib/problem/ranges.h"
#include "calib/start/label_check.h"
#include "calib/statements/agreement.h"
#include "calib/statements/common_errors.h"
#include "calib/statements/statements.h"
#include "calib/verdict/datum.h"
#include "calib/verdict/observability.h"
#include "calib/verdict/shadows.h"

namespace octant::calib {
namespace {

/// Fewer degrees of freedom behind the variances than this are said.
constexpr double kFewFreedoms = 12.0;

/// Amplitudes that are taken to be alike all round receivers that have axes.
bool may_be_directional(const Problem& problem, const std::vector<Trajectory>& trajectories) {
  const Site& site = problem.site;
  if (!site.attenuation || site.attenuation->half_power_angle_rad.value > 0) return false;
  const auto measured = [](const Trajectory& t) {
    return std::ranges::any_of(t.arrivals,
                               [](const ArrivalObservation& a) { return a.log_amplitude_sigma > 0; });
  };
  return std::ranges::any_of(site.receivers, [](const SiteReceiver& r) { return r.axis.has_value(); }) &&
         std::ranges::any_of(trajectories, measured);
}

/// Median over the parameters of how much larger the sigmas are than those of white noise; 1 where errors are
/// white.
double growth_of_sigmas(const Solution& solution) {
  std::vector<double> growth;
  const Eigen::MatrixXd &honest = solution.covariance.matrix, &white = solution.white_covariance.matrix;
  for (Eigen::Index i = 0; i < white.rows(); ++i)
    if (white(i, i) > 0) growth.push_back(std::sqrt(honest(i, i) / white(i, i)));
  return growth.empty() ? 1.0 : std::max(1.0, median(std::move(growth)));
}

void warn_of_correlation(const Estimate& estimate, const std::vector<Trajectory>& trajectories, int threads,
                         Solution& solution) {
  const ErrorModel& errors = solution.errors;
  if (errors.correlated) {
    constexpr double kAsGood = 1.05;  // what two digits write as 1
    const double growth = growth_of_sigmas(solution);
    std::string warning = fmt::format(
        "errors are correlated: residuals of a beacon-receiver pair keep a common part, as reflections, "
        "antennas and bodies cause, "
        "which does not average out as white noise does; stated sigmas allow for it and are {} those of "
        "white noise",
        growth < kAsGood ? "as good as" : fmt::format("{:.2g} times", growth));
    if (errors.freedoms < kFewFreedoms)
      warning += fmt::format(
          "; the log is too short to estimate them well (some {:.0f} independent stretches): record longer, "
          "over "
          "other ground, and sigmas will shrink",
          errors.freedoms);
    solution.warnings.push_back(std::move(warning));
  } else if (!is_dense(estimate.layout)) {
    const Whiteness w = whiteness_of(trajectories, solution.state, threads);
    if (w.white) return;
    solution.warnings.push_back(fmt::format(
        "residuals are no white noise (correlation between neighbours of a pair {:.2f}), and a site of so "
        "many unknowns has no model "
        "of that: such errors do not average out, so expect beacons off by several times their stated sigmas",
        w.autocorrelation));
  }
}

/// Sigmas that hold with the errors as the residuals show them.
void allow_for_correlation(const Estimate& estimate, const Covariance& C,
                           const std::vector<Trajectory>& trajectories, double share_of_log, int threads,
                           Solution& solution) {
  solution.errors = error_model_of(estimate.layout, trajectories, solution.state, C, share_of_log, threads);
  if (!solution.errors.correlated || solution.covariance.parameters.empty()) return;
  solution.white_covariance = solution.covariance;
  const Eigen::VectorXd si = estimate.layout.si_per_unit();
  solution.covariance.matrix = si.asDiagonal() * solution.errors.covariance * si.asDiagonal();
}

/// Sigmas that hold though some beacon may have been shadowed at a stop.
/// @return what is to be said of it; empty: nothing
std::string allow_for_shadows(const Problem& problem, const Estimate& estimate, const Covariance& C,
                              const std::vector<Trajectory>& trajectories, Solution& solution) {
  constexpr double kWorthTelling = 1.5;  // times a sigma
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
      "of what beacons sent to stops {:.2g} % came late at all receivers; where few beacons are heard, such "
      "echoes show in no residual, and the sigmas of {} allow for that: record more stops there",
      100 * risk.share, fmt::join(grown, ", "));
}

/// Poses that are far better than stated say little of the arrivals' noise while they are taken for so bad.
constexpr double kFarBetterPoses = 0.5;

void warn_of_noise(const Problem& problem, const Estimate& estimate,
                   const std::vector<Trajectory>& trajectories, int threads, Solution& solution) {
  const CalibrationStatistics& s = solution.statistics;
  const double noise_factor = estimate.noise_factor;
  if (estimate.pose_factor < kFarBetterPoses)
    solution.warnings.push_back(
        fmt::format("measured poses fit {:.1f} times better than stated and are weighted so; state poses: "
                    "position_sigma_m and heading_sigma_rad in run.yaml as they are",
                    1.0 / estimate.pose_factor));
  if (s.redundancy >= 30 && noise_factor > 1.2)
    solution.warnings.push_back(
        fmt::format("residuals are {:.2f} times the stated noise (variance factor {:.3g}); sigmas are scaled "
                    "to the residuals, "
                    "state noise.tof_sigma_s as it is",
                    noise_factor, s.variance_factor));
  if (s.redundancy >= 30 && noise_factor > 1.2 && may_be_directional(problem, trajectories))
    solution.warnings.push_back(
        "amplitudes are assumed to be alike all round each receiver: where these hear less off their axes, "
        "state "
        "attenuation.half_power_angle_rad (half of the beam width at -3 dB, with a sigma)");
  warn_of_correlation(estimate, trajectories, threads, solution);
}

SolveStatus status_of(const AdjustResult& last) {
  return last.converged ? SolveStatus::kConverged : SolveStatus::kNotConverged;
}

std::string message_of(const AdjustResult& last) {
  return last.converged ? "converged" : "the adjustment did not converge: " + last.message;
}

/// Whether the ranges alone show that a clock jumped, and the adjustment is bent by it. No statement is to
/// blame for that, whatever its release would explain; what is, other readings (readings/) tell.
bool is_bent_by_a_clock(const Problem& problem, const Solution& solution) {
  return are_many_left_out(problem, solution) && ranges_show_a_jump(problem.site, problem.runs);
}

bool are_few_left_out(const std::vector<Trajectory>& trajectories) {
  constexpr double kFew = 0.15;
  std::size_t all = 0, out = 0;
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals) ++all, out += is_outlier(a.rejection);
  return static_cast<double>(out) <= kFew * static_cast<double>(all);
}

/// What was stated, and the recording with itself, against what the data say.
void contradict(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                const std::vector<Trajectory>& trajectories, Solution& solution) {
  StatementFindings stated = test_statements(problem, options, estimate, trajectories);
  solution.common_errors = std::move(stated.errors);
  for (Contradiction& c : stated.contradictions) solution.contradictions.push_back(std::move(c));
  if (!stated.fit) return;
  if (are_few_left_out(stated.fit->trajectories))
    for (CommonError& e : solution.common_errors)
      e.noise_left = stated.fit->noise_factor * estimate.noise_factor;
  Agreement agreement =
      agreement_of(problem, options, *stated.fit, solution.contradictions, growth_of_sigmas(solution));
  for (Contradiction& c : agreement.contradictions) solution.contradictions.push_back(std::move(c));
  for (std::string& warning : agreement.warnings) solution.warnings.push_back(std::move(warning));
  if (solution.contradictions.empty())
    for (std::string& warning : stated.warnings) solution.warnings.push_back(std::move(warning));
}

/// A refusal by sigmas that the misfit made so large: what causes the misfit comes first.
bool is_refused_for_misfit(const Solution& solution, const Estimate& estimate) {
  constexpr double kMisfit = 2.0;  // times the stated noise
  return solution.status == SolveStatus::kUndetermined && estimate.noise_factor > kMisfit;
}

/// Covariance and verdict, and only these, from other weights of the observations.
void judge_anew(const Problem& problem, const SolveOptions& options, Estimate estimate,
                std::vector<Trajectory>& trajectories, Solution& solution) {
  solution.status = status_of(estimate.last);
  solution.message = message_of(estimate.last);
  solution.covariance = {};
  solution.marginals = {};
  solution.beacon_status.clear();
  solution.weak.clear();
  solution.undetermined.clear();
  estimate.last.data.reset();  // which is of the subsampled log
  static_cast<void>(judge(problem, options, estimate, trajectories, solution));
}

/// @param is_subsampled  the verdict is judged anew, by all that the log stands for
/// @param judged  set to where the warnings of the verdict are
void conclude_as_is(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                    Findings findings, bool is_subsampled, std::vector<Trajectory>& trajectories,
                    Solution& solution, std::pair<std::size_t, std::size_t>& judged) {
  const AdjustResult& last = estimate.last;
  solution.state = estimate.state();
  solution.final_cost = last.cost;
  solution.tof_sigma_s = problem.site.noise.tof_sigma_s * estimate.noise_factor;
  solution.statistics = findings.statistics;
  solution.statistics.converged = last.converged;
  // The factor is told against what the site file states, not against the noise as found.
  solution.statistics.variance_factor *= estimate.noise_factor * estimate.noise_factor;
  solution.statistics.chi2_p = chi_square_p(
      solution.statistics.variance_factor * solution.statistics.redundancy, solution.statistics.redundancy);
  solution.status = status_of(last);
  solution.message = message_of(last);
  solution.datum = datum_of(problem);
  judged.first = solution.warnings.size();
  // What the data do not determine is often what keeps the iteration from settling, and then that is the
  // finding.
  const Covariance C = judge(problem, options, estimate, trajectories, solution);
  judged.second = solution.warnings.size();
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
  if ((solution.status == SolveStatus::kConverged || is_refused_for_misfit(solution, estimate)) &&
      !is_bent_by_a_clock(problem, solution))
    contradict(problem, options, estimate, trajectories, solution);
  const std::string shadowed =
      is_whole ? allow_for_shadows(problem, estimate, C, trajectories, solution) : "";
  if (!solution.contradictions.empty())
    return;  // which tell the culprit; what follows would name the innocent
  warn_of_noise(problem, estimate, trajectories, options.threads, solution);
  if (!shadowed.empty()) solution.warnings.push_back(shadowed);
  for (std::string& warning : suspect_control_points(problem, solution.state, trajectories))
    solution.warnings.push_back(std::move(warning));
}

}  // namespace

void conclude(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
              Findings findings, Solution& solution) {
  std::vector<Trajectory> trajectories = std::move(findings.trajectories);
  std::vector<Trajectory> as_complete = std::move(findings.as_complete);
  std::pair<std::size_t, std::size_t> judged;
  conclude_as_is(problem, options, estimate, std::move(findings), !as_complete.empty(), trajectories,
                 solution, judged);
  solution.trajectories = std::move(trajectories);
  if (as_complete.empty()) return;
  const auto begin = solution.warnings.begin();
  solution.warnings.erase(begin + static_cast<std::ptrdiff_t>(judged.first),
                          begin + static_cast<std::ptrdiff_t>(judged.second));
  judge_anew(problem, options, estimate, as_complete, solution);
}

}  // namespace octant::calib
