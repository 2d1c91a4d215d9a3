// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/calibrate.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "calib/readings/explain.h"
#include "calib/solution/range_review.h"
#include "calib/statements/common_errors.h"
#include "calib/statements/hints.h"
#include "calib/streamed.h"
#include "models/trajectory/ray_speeds.h"

namespace octant::calib {
namespace {

void add(std::vector<Finding> found, const CalibrationOptions& options, Calibration& calibration) {
  for (Finding& finding : found) {
    if (options.on_finding) options.on_finding(finding);
    calibration.findings.push_back(std::move(finding));
  }
}

/// Adjusts a problem. Where the medium has a profile, the speeds of the arrivals are those of their rays,
/// which depend on the result: the adjustment is repeated until no path changes by more than the tolerance.
Solution solve_with_rays(Problem& problem, const SolveOptions& options) {
  constexpr int kMostRounds = 4;
  constexpr double kStill_m = 1e-3;  // a tenth of the best noise in water
  const auto& profile = problem.site.medium.profile;
  if (profile == nullptr) return solve_in_place(problem, options);
  Solution solution = solve(problem, options);
  for (int round = 0; round < kMostRounds && solution.status == SolveStatus::kConverged; ++round) {
    double moved_m = 0.0;
    for (std::size_t t = 0; t < solution.trajectories.size(); ++t) {
      Trajectory& solved = solution.trajectories[t];
      moved_m = std::max(moved_m, set_ray_speeds(solved, solution.state, *profile));
      for (std::size_t i = 0; i < solved.arrivals.size(); ++i)
        problem.trajectories[t].arrivals[i].model_speed_mps = solved.arrivals[i].model_speed_mps;
    }
    if (moved_m < kStill_m) break;
    solution = solve(problem, options);
  }
  return solution;
}

/// Adjusts a problem. Ranges between beacons are reviewed first against an adjustment without them.
Solution solve_with_ranges(Problem& problem, const SolveOptions& options) {
  if (problem.beacon_ranges.pairs.empty()) return solve_with_rays(problem, options);
  BeaconRanges ranges = std::exchange(problem.beacon_ranges, {});
  const Solution without = solve(problem, options);
  problem.beacon_ranges = std::move(ranges);
  std::vector<std::string> words;
  if (without.status == SolveStatus::kConverged)
    words = review_ranges(problem, without.state, without.covariance);
  Solution solution = solve_with_rays(problem, options);
  solution.warnings.insert(solution.warnings.end(), words.begin(), words.end());
  return solution;
}

/// If measured poses have a constant lag and the solution has no contradiction, adjusts again with corrected
/// times. A warning reports the lag.
/// @param stated  the site as the caller stated it
Result<void> correct_lags(Site stated, const CalibrationOptions& options, Calibration& calibration) {
  std::vector<CommonError> lags = calibration.solution.common_errors;
  std::erase_if(lags, [](const CommonError& e) { return e.kind != CommonError::Kind::kLag; });
  if (lags.empty() || !calibration.solution.contradictions.empty()) return {};
  std::vector<std::string> words;
  std::vector<MeasurementLog> runs = std::move(calibration.problem.runs);
  for (const CommonError& lag : lags) {
    const Contradiction found = contradiction_of(lag, stated, runs);
    words.push_back(octant::in_words(found) + "; they are corrected for this calibration; " + found.remedy);
    for (TimedPose& pose : runs[lag.run].poses) pose.time_s -= lag.size;
  }
  auto problem = make_problem(std::move(stated), std::move(runs), options.solve.threads);
  if (!problem) return fail(problem.error());
  problem->beacon_ranges = beacon_ranges(problem->site, options.beacon_flights, problem->runs);
  calibration.problem = std::move(*problem);
  calibration.solution = solve_with_ranges(calibration.problem, options.solve);
  auto& warnings = calibration.solution.warnings;
  warnings.insert(warnings.end(), words.begin(), words.end());
  return {};
}

/// The steps after the adjustment. `logs`: the recordings, whose digests the deployment gets.
Calibration finish(Calibration calibration, std::span<const MeasurementLog* const> logs,
                   const CalibrationOptions& options) {
  Solution& solution = calibration.solution;
  explain(calibration.problem, calibration.problem, solution, options.solve);
  if (solution.contradictions.empty())
    add(outcome_hints(calibration.problem, solution), options, calibration);
  calibration.provenance = options.provenance;
  for (const MeasurementLog* log : logs)
    for (const auto& [path, sha256] : log->sha256) calibration.provenance.inputs.push_back({path, sha256});
  if (solution.status == SolveStatus::kConverged)
    calibration.deployment = make_deployment(calibration.problem, solution, calibration.provenance);
  return calibration;
}

/// Calibrates devices with clocks of their own.
Result<Calibration> calibrate_free(Site site, std::vector<MeasurementLog> runs,
                                   const CalibrationOptions& options) {
  auto solved = calibrate_clocks(std::move(site), std::move(runs), *options.clocks, options.solve);
  if (!solved) return fail(solved.error());
  Calibration calibration;
  calibration.problem = std::move(solved->problem);
  calibration.solution = std::move(solved->solution);
  calibration.clocks = std::move(solved->clocks);
  calibration.provenance = options.provenance;
  add(std::move(solved->findings), options, calibration);
  if (calibration.solution.status == SolveStatus::kConverged)
    calibration.deployment =
        make_deployment(calibration.problem, calibration.solution, calibration.provenance);
  return calibration;
}

}  // namespace

Result<Calibration> calibrate(Site site, std::vector<MeasurementLog> runs,
                              const CalibrationOptions& options) {
  if (options.clocks) return calibrate_free(std::move(site), std::move(runs), options);
  Calibration calibration;
  add(log_hints(site, runs), options, calibration);
  auto problem = make_problem(site, std::move(runs), options.solve.threads);
  if (!problem) return fail(problem.error());
  problem->beacon_ranges = beacon_ranges(problem->site, options.beacon_flights, problem->runs);
  calibration.problem = std::move(*problem);
  calibration.solution = solve_with_ranges(calibration.problem, options.solve);
  if (auto ok = correct_lags(std::move(site), options, calibration); !ok) return fail(ok.error());
  std::vector<const MeasurementLog*> logs;
  for (const MeasurementLog& run : calibration.problem.runs) logs.push_back(&run);
  return finish(std::move(calibration), logs, options);
}

Result<Calibration> calibrate(const Site& site, ArrivalSource& source, const CalibrationOptions& options) {
  auto streamed = solve_streamed(site, source, options.solve, options.memory_bytes);
  if (!streamed) return fail(streamed.error());
  Calibration calibration;
  calibration.problem = std::move(streamed->problem);
  calibration.solution = std::move(streamed->solution);
  // The runs are those of the whole log, or an evenly spread part of it.
  const auto& totals = calibration.solution.totals;
  add(log_hints(site, calibration.problem.runs, !totals || totals->stride == 1), options, calibration);
  std::vector<const MeasurementLog*> logs;
  for (std::size_t run = 0; run < source.runs(); ++run) logs.push_back(&source.log(run));
  return finish(std::move(calibration), logs, options);
}

}  // namespace octant::calib
