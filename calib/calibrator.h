// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/log/calibration_log.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "calib/start/progress_monitor.h"

namespace octant::calib {

/// Calibration of a log in memory or in a source, for solve() and solve_streamed(). With m the shared
/// parameters, x the vehicle states and I the inliers among the arrivals it minimises
///   1/2 sum over I of (r(m, x) / sigma)^2 + 1/2 |m - prior|^2
/// alternately over m, x, I and sigma; the states are eliminated (variable projection). Errors: those of
/// reading the log.
[[nodiscard]] Result<Solution> solve_log(CalibrationLog& log, const SolveOptions& options,
                                         ProgressMonitor& monitor);

}  // namespace octant::calib
