// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "calib/problem/finding.h"
#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "calib/solve.h"
#include "models/arrival_source.h"
#include "models/deployment.h"
#include "models/support/result.h"

namespace octant::calib {

/// Where a deployment came from.
struct Provenance {
  std::string created;  ///< ISO 8601, UTC
  std::string version;
  std::string command;
  std::vector<InputDigest> inputs;
};

/// The deployment of a solution with status kConverged.
[[nodiscard]] Deployment make_deployment(const Problem& problem, const Solution& solution,
                                         const Provenance& provenance);
/// What a deployment takes over from the site and from where it came, whatever the outcome: all but what was
/// solved for.
[[nodiscard]] Deployment deployment_head(const Site& site, const Solution& solution,
                                         const Provenance& provenance);

/// All that came of a calibration, whatever the outcome.
struct Calibration {
  Problem problem;                       ///< site and recordings; of a streamed log those that were sampled
  Solution solution;                     ///< estimate, errors, verdict, contradictions
  std::vector<Finding> findings;         ///< what recordings and outcome show beside the contradictions
  Provenance provenance;                 ///< that of the options, with the digests of the recordings
  std::optional<Deployment> deployment;  ///< of a solution with status kConverged
};

struct CalibrationOptions {
  SolveOptions solve;
  Provenance provenance;                                ///< without the recordings
  std::size_t memory_bytes = std::size_t{1500} << 20U;  ///< bound of a log that is streamed
  /// Called with each finding as soon as it is known, so that findings are known where an error ends the
  /// calibration.
  std::function<void(const Finding&)> on_finding;
};

/// The product: health of the recordings, bundle adjustment, verdict, diagnosis, deployment. Command line,
/// Python and C++ call it for recordings of all sizes and get the same words.
///   1. log_hints(): what the recordings show before anything is solved,
///   2. solve(), or solve_streamed(): estimate, covariance and verdict (calibrator.cc), then statements that
///   the
///      data contradict (verdict/diagnose.h),
///   3. explain(): where the outcome is poor, what is wrong as a whole (units, wiring, frames, clocks),
///   4. outcome_hints() where nothing is contradicted, and the deployment.
/// Steps that diagnose have a budget (solution/diagnosis_budget.h). Errors: runs that do not fit the site.
[[nodiscard]] Result<Calibration> calibrate(Site site, std::vector<MeasurementLog> runs,
                                            const CalibrationOptions& options = {});
/// Calibrates recordings that are read again for each step (streamed.h). Errors: those of the source, too.
[[nodiscard]] Result<Calibration> calibrate(const Site& site, ArrivalSource& source,
                                            const CalibrationOptions& options = {});

}  // namespace octant::calib
