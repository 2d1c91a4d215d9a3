// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/diagnose.h"

#include <algorithm>

#include <fmt/format.h>

#include "calib/errors/whiteness.h"
#include "calib/problem/clock_check.h"
#include "calib/problem/ranges.h"
#include "calib/solution/diagnosis_budget.h"
#include "calib/start/label_check.h"
#include "calib/statements/agreement.h"
#include "calib/statements/statements.h"

namespace octant::calib {
namespace {

/// Degrees of freedom of the variances below which there is a warning.
constexpr double kFewFreedoms = 12.0;

/// Returns true if amplitudes are modelled as independent of the direction although receivers have axes.
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

/// Median ratio of the sigmas to those under white noise; 1 if errors are white.
double growth_of_sigmas(const Solution& solution) {
  std::vector<double> growth;
  const Eigen::MatrixXd &honest = solution.covariance.matrix, &white = solution.white_covariance.matrix;
  for (Eigen::Index i = 0; i < white.rows(); ++i)
    if (white(i, i) > 0) growth.push_back(std::sqrt(honest(i, i) / white(i, i)));
  return growth.empty() ? 1.0 : std::max(1.0, median(std::move(growth)));
}

void warn_of_correlation(const Estimate& estimate, int threads, Solution& solution) {
  const ErrorModel& errors = solution.errors;
  const double growth = growth_of_sigmas(solution);
  if (errors.correlated) {
    constexpr double kAsGood = 1.05;  // rounded to 1 with two digits
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
    const Whiteness w = whiteness_of(solution.trajectories, solution.state, threads);
    if (w.white) return;
    solution.warnings.push_back(fmt::format(
        "residuals are no white noise (correlation between neighbours of a pair {:.2f}), and a site of so "
        "many unknowns has no model "
        "of that: such errors do not average out, so expect beacons off by several times their stated sigmas",
        w.autocorrelation));
  }
}

/// Ratio of the estimated pose noise to the expected one below which there is a warning. Poses with too
/// little weight carry little information on the noise of the arrivals.
constexpr double kFarBetterPoses = 0.5;

void warn_of_noise(const Problem& problem, const Estimate& estimate, int threads, Solution& solution) {
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
  if (s.redundancy >= 30 && noise_factor > 1.2 && may_be_directional(problem, solution.trajectories))
    solution.warnings.push_back(
        "amplitudes are assumed to be equal in all directions at each receiver: if they decrease off its "
        "axis, state attenuation.half_power_angle_rad (half of the beam width at -3 dB, with a sigma)");
  warn_of_correlation(estimate, threads, solution);
}

/// Returns true if the ranges alone show a jump of a clock that distorts the adjustment. Assumptions are not
/// tested then, because their release would absorb the jump; the search for misreadings (readings/) finds the
/// cause.
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

/// Tests the assumptions of the site file, and the consistency of the recordings, by the data.
void contradict(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                Solution& solution) {
  StatementFindings stated = test_statements(problem, options, estimate, solution.trajectories);
  // One beacon that moved is more likely than several false assumptions that explain less.
  if (!stated.contradictions.empty() && stated.errors.empty()) {
    std::vector<Contradiction> moves = moves_of(problem, options, *stated.as_stated, stated.fit->cost);
    if (!moves.empty()) {
      stated.contradictions = std::move(moves);
      stated.fit = std::move(stated.as_stated);
    }
  }
  solution.common_errors = std::move(stated.errors);
  for (Contradiction& c : stated.contradictions) solution.contradictions.push_back(std::move(c));
  if (!stated.fit) return;
  if (are_few_left_out(stated.fit->trajectories))
    for (CommonError& e : solution.common_errors)
      e.noise_left = stated.fit->noise_factor * estimate.noise_factor;
  Agreement agreement = agreement_of(problem, options, *stated.fit, solution.contradictions);
  for (Contradiction& c : agreement.contradictions) solution.contradictions.push_back(std::move(c));
  for (std::string& warning : agreement.warnings) solution.warnings.push_back(std::move(warning));
  if (solution.contradictions.empty())
    for (std::string& warning : stated.warnings) solution.warnings.push_back(std::move(warning));
}

/// Returns true if a calibration is refused only because the misfit enlarged its sigmas. The cause of the
/// misfit then comes first.
bool is_refused_for_misfit(const Solution& solution, const Estimate& estimate) {
  constexpr double kMisfit = 2.0;  // ratio to the noise in the site file
  return solution.status == SolveStatus::kUndetermined && estimate.noise_factor > kMisfit;
}

}  // namespace

void diagnose(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
              Solution& solution) {
  const bool is_tested =
      solution.status == SolveStatus::kConverged || is_refused_for_misfit(solution, estimate);
  // The other half is for gross errors (readings/), which look like many false assumptions.
  constexpr double kShareOfStatements = 0.5;
  diagnose_within_budget(options, solution, kShareOfStatements, [&](const SolveOptions& limited) {
    if (is_tested && !is_bent_by_a_clock(problem, solution)) contradict(problem, limited, estimate, solution);
  });
}

void add_warnings(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                  const std::string& shadowed, Solution& solution) {
  warn_of_noise(problem, estimate, options.threads, solution);
  if (!shadowed.empty()) solution.warnings.push_back(shadowed);
  for (std::string& warning : suspect_control_points(problem, solution.state, solution.trajectories))
    solution.warnings.push_back(std::move(warning));
}

}  // namespace octant::calib
