// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/calibrate.h"

#include <utility>

#include "calib/readings/explain.h"
#include "calib/statements/hints.h"
#include "calib/streamed.h"

namespace octant::calib {
namespace {

void add(std::vector<Finding> found, const CalibrationOptions& options, Calibration& calibration) {
  for (Finding& finding : found) {
    if (options.on_finding) options.on_finding(finding);
    calibration.findings.push_back(std::move(finding));
  }
}

/// The steps after the adjustment.
Calibration finish(Calibration calibration, const CalibrationOptions& options) {
  Solution& solution = calibration.solution;
  explain(calibration.problem, calibration.problem, solution, options.solve);
  if (solution.contradictions.empty())
    add(outcome_hints(calibration.problem, solution), options, calibration);
  if (solution.status == SolveStatus::kConverged)
    calibration.deployment = make_deployment(calibration.problem, solution, options.provenance);
  return calibration;
}

}  // namespace

Result<Calibration> calibrate(Site site, std::vector<MeasurementLog> runs,
                              const CalibrationOptions& options) {
  Calibration calibration;
  add(log_hints(site, runs), options, calibration);
  auto problem = make_problem(std::move(site), std::move(runs), options.solve.threads);
  if (!problem) return fail(problem.error());
  calibration.problem = std::move(*problem);
  calibration.solution = solve_in_place(calibration.problem, options.solve);
  return finish(std::move(calibration), options);
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
  return finish(std::move(calibration), options);
}

}  // namespace octant::calib
