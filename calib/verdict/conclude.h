// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/adjust/covariance.h"
#include "calib/problem/log_totals.h"
#include "calib/start/approach.h"
#include "calib/verdict/left_out.h"

namespace octant::calib {

/// Results of one pass over all arrivals of a log at an estimate, and the states for the verdict.
struct Findings {
  std::vector<Trajectory>
      trajectories;  ///< solved, outliers rejected; all, or an evenly spread part of the stops or segments
  std::vector<std::string> warnings;
  CalibrationStatistics statistics;  ///< relative to the estimated noise
  std::vector<std::string> flips;    ///< descriptions of epochs whose heading was corrected
  LeftOutOfAll left_out;
  std::optional<LogTotals> totals;  ///< set if the trajectories are only a part of the log
  /// Trajectories of a subsampled log with the accuracy of the complete log, for covariance and verdict.
  /// Empty if the log is not subsampled.
  std::vector<Trajectory> as_complete;
};

/// Completes a calibration: covariance, verdict, reliability and sigmas under correlated errors; fills the
/// solution, which has warnings already. It names no culprits (diagnose.h).
/// @return warning of shadowed beacons, or an empty text
[[nodiscard]] std::string conclude(const Problem& problem, const SolveOptions& options,
                                   const Estimate& estimate, Findings findings, Solution& solution);

}  // namespace octant::calib
