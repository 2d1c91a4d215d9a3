// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "calib/clocks/calibrate_clocks.h"
#include "calib/problem/finding.h"
#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "calib/solve.h"
#include "models/arrival_source.h"
#include "models/deployment.h"
#include "models/support/result.h"

namespace octant::calib {

/// Provenance of a deployment.
struct Provenance {
  std::string created;  ///< ISO 8601, UTC
  std::string version;
  std::string command;
  std::vector<InputDigest> inputs;
};

/// The deployment of a solution with status kConverged.
[[nodiscard]] Deployment make_deployment(const Problem& problem, const Solution& solution,
                                         const Provenance& provenance);
/// Fields of a deployment that follow from the site and the provenance for any outcome: all except the
/// estimated ones.
[[nodiscard]] Deployment deployment_head(const Site& site, const Solution& solution,
                                         const Provenance& provenance);

/// All results of a calibration, for any outcome.
struct Calibration {
  Problem problem;                  ///< site and recordings; for a streamed log the sampled ones
  Solution solution;                ///< estimate, errors, verdict, contradictions
  std::vector<Finding> findings;    ///< findings in recordings and outcome, in addition to the contradictions
  Provenance provenance;            ///< provenance in the options, with the digests of the recordings
  std::vector<ClockResult> clocks;  ///< of devices with clocks of their own, run by run
  std::optional<Deployment> deployment;  ///< set if the status is kConverged
};

struct CalibrationOptions {
  SolveOptions solve;
  Provenance provenance;                                ///< without the recordings
  std::size_t memory_bytes = std::size_t{1500} << 20U;  ///< bound for a streamed log
  std::vector<BeaconFlight> beacon_flights = {};        ///< ranges between beacons; not for streamed logs
  std::optional<ClockInput> clocks = {};                ///< set: calibrate_clocks() (clocks/)
  /// Called immediately for each finding, so that findings are available if an error ends the calibration.
  std::function<void(const Finding&)> on_finding;
};

/// The complete method: health of the recordings, bundle adjustment, verdict, diagnosis, deployment. Command
/// line, Python and C++ call it for recordings of all sizes, with the same results.
///   1. log_hints(): checks of the recordings before the solution,
///   2. solve(), or solve_streamed(): estimate, covariance and verdict (calibrator.cc), then assumptions that
///      the data contradict (verdict/diagnose.h),
///   3. explain(): for a poor outcome, a cause that affects everything (units, wiring, frames, clocks),
///   4. outcome_hints() if there is no contradiction, and the deployment.
/// Diagnostic steps have a budget (solution/diagnosis_budget.h). Errors: runs that do not fit the site.
[[nodiscard]] Result<Calibration> calibrate(Site site, std::vector<MeasurementLog> runs,
                                            const CalibrationOptions& options = {});
/// Calibrates recordings that are read again for each step (streamed.h). Errors: also those of the source.
[[nodiscard]] Result<Calibration> calibrate(const Site& site, ArrivalSource& source,
                                            const CalibrationOptions& options = {});

}  // namespace octant::calib
