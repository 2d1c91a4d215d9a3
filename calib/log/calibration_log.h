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

/// A log as its calibration (calibrator.h) sees it. It is held in memory (held_log.h), or too long for that
/// and read again for each look at it (streamed.cc). Errors of all: those of reading,
/// Errc::kInterrupted where the course is to stop.
class CalibrationLog {
 public:
  virtual ~CalibrationLog() = default;

  /// Site, and runs as far as they are at hand; of a log that is read, from the first sample on.
  [[nodiscard]] virtual const Problem& problem() const = 0;

  struct Sample {
    const Problem* problem = nullptr;  ///< null: there is no other one
    bool is_complete = false;
  };
  /// What a start may be made from. Of a long log that is first a part, evenly spread stops and stretches: it
  /// tells all shared parameters to a fraction of the noise. To be asked for another one where that gave
  /// none.
  [[nodiscard]] virtual Result<Sample> next_sample() = 0;

  /// Has the states of all from a start from the last sample, its own or new ones.
  /// @param sigma  of the start's residuals that agree (reject.h)  @return the same of all
  [[nodiscard]] virtual Result<double> place(Approach& start, double sigma) = 0;

  /// Plain squares on the arrivals within so many sigmas, which are rejected and readmitted until neither
  /// they nor parameters change.
  /// @return the squares with the noise as it is
  [[nodiscard]] virtual Result<DataSquares> adjust_inliers(Estimate& estimate) = 0;
  /// Noise is so many times what it was.
  virtual void scale_noise(Estimate& estimate, const NoiseFactors& factors) = 0;

  /// The end: nothing is asked of it any more.
  [[nodiscard]] virtual Result<Findings> findings(const Estimate& estimate) = 0;

 protected:
  CalibrationLog() = default;
  CalibrationLog(const CalibrationLog&) = default;
  CalibrationLog& operator=(const CalibrationLog&) = default;
};

}  // namespace octant::calib
