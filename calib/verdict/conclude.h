// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/problem/log_totals.h"
#include "calib/start/approach.h"
#include "calib/verdict/left_out.h"

namespace octant::calib {

/// What all arrivals of a log say of an estimate, and the states that the verdict looks at.
struct Findings {
  std::vector<Trajectory>
      trajectories;  ///< solved, outliers rejected; all, or every so many-th stop or stretch
  std::vector<std::string> warnings;
  CalibrationStatistics statistics;  ///< against the noise as found
  std::vector<std::string> flips;    ///< epochs that were turned, in words
  LeftOutOfAll left_out;
  std::optional<LogTotals> totals;  ///< where the trajectories at hand are only a part of the log
  /// The trajectories of a subsampled log with the accuracy of all that they stand for: covariance and
  /// verdict are judged by them. Empty: the log is not subsampled.
  std::vector<Trajectory> as_complete;
};

/// The end of a calibration: covariance, verdict, reliability and what is to be said of them; fills the
/// solution, which has warnings already.
void conclude(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
              Findings findings, Solution& solution);

}  // namespace octant::calib
