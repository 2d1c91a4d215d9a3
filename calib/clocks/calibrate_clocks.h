// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/problem/finding.h"
#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "models/clocks/clock_log.h"
#include "models/support/result.h"

namespace octant::calib {

/// Receptions of devices with clocks of their own, one log for each recording.
struct ClockInput {
  std::vector<ClockLog> logs;
  ClockModel model;
};

/// Clock of a device relative to the time base of its run.
struct ClockResult {
  std::string name;
  std::size_t run = 0;
  double time_s = 0.0;  ///< time at which offset and rate are given
  double offset_s = 0.0, offset_sigma_s = 0.0;
  double rate = 0.0, rate_sigma = 0.0;  ///< relative
};

struct ClockCalibration {
  Problem problem;
  Solution solution;
  std::vector<Finding> findings;
  std::vector<ClockResult> clocks;  ///< run by run
};

/// Calibrates a site whose devices have clocks of their own (clock_problem.h):
///   1. a start from some points of the recordings, with many random initial values (clock_start.cc),
///   2. an adjustment of all receptions with the noise as found (clock_fit.h),
///   3. steps of clocks, exchanged beacons and wrong positions (clock_findings.h),
///   4. covariance and verdict.
/// @param runs  recordings, with the motion of the vehicles
[[nodiscard]] Result<ClockCalibration> calibrate_clocks(Site site, std::vector<MeasurementLog> runs,
                                                        const ClockInput& input, const SolveOptions& options);

}  // namespace octant::calib
