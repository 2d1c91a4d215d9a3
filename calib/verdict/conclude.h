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

/// Parts of a conclusion that a diagnosis starts from.
struct Conclusion {
  Covariance covariance;      ///< of the parameters under white noise, internal units
  double growth = 1.0;        ///< of sigmas by correlated errors
  double share_of_log = 1.0;  ///< part of the log that the solution's trajectories are
  std::string shadowed = {};  ///< warning of shadowed beacons; empty: there is none
};

/// Completes a calibration: covariance, verdict, reliability and sigmas under correlated errors; fills the
/// solution, which has warnings already. It names no culprits (diagnose.h).
[[nodiscard]] Conclusion conclude(const Problem& problem, const SolveOptions& options,
                                  const Estimate& estimate, Findings findings, Solution& solution);

}  // namespace octant::calib
