// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/errors/statistics.h"
#include "calib/problem/problem.h"
#include "calib/start/approach.h"
#include "calib/verdict/conclude.h"
#include "models/support/result.h"

namespace octant::calib {

/// A log as the calibration (calibrator.h) uses it. It is in memory (held_log.h), or too long for that and
/// read in each pass (streamed.cc). Errors of all functions: those of the reader, Errc::kInterrupted if the
/// calibration is cancelled.
class CalibrationLog {
 public:
  virtual ~CalibrationLog() = default;

  /// Site, and the runs in memory; for a log that is read, after the first sample.
  [[nodiscard]] virtual const Problem& problem() const = 0;

  struct Sample {
    const Problem* problem = nullptr;  ///< null: there is no other one
    bool is_complete = false;
  };
  /// Sample for the start. For a long log the first sample is a part, evenly spaced stops and segments, which
  /// determines all shared parameters to a fraction of the noise. Another one may be requested if it fails.
  [[nodiscard]] virtual Result<Sample> next_sample() = 0;

  /// Has the states of all from a start from the last sample, its own or new ones.
  /// @param sigma  of the start's residuals that agree (reject.h)  @return the same of all
  [[nodiscard]] virtual Result<double> place(Approach& start, double sigma) = 0;

  /// Adjusts the arrivals within the given number of sigmas with plain squares; arrivals are rejected and
  /// readmitted until neither they nor the parameters change.
  /// @return the squares with the present noise
  [[nodiscard]] virtual Result<DataSquares> adjust_inliers(Estimate& estimate) = 0;
  /// Rescales the noise by a factor.
  virtual void scale_noise(Estimate& estimate, const NoiseFactors& factors) = 0;

  /// Results of the whole log at an estimate, with its trajectories.
  [[nodiscard]] virtual Result<Findings> findings(const Estimate& estimate) = 0;
  /// Continues after findings() with the trajectories that it returned.
  virtual void resume(const std::vector<Trajectory>& /*trajectories*/) {}

 protected:
  CalibrationLog() = default;
  CalibrationLog(const CalibrationLog&) = default;
  CalibrationLog& operator=(const CalibrationLog&) = default;
};

}  // namespace octant::calib
