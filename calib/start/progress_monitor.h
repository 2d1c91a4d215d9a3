// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

#include "calib/adjust/adjust.h"
#include "calib/solution/solve_options.h"
#include "models/support/result.h"

namespace octant::calib {

/// Error of a cancelled calibration.
[[nodiscard]] inline auto interrupted() { return fail({.code = Errc::kInterrupted, .found = "interrupted"}); }

/// Progress of a calibration: reports it to the caller, who may cancel.
class ProgressMonitor {
 public:
  /// @param options  outlive it
  explicit ProgressMonitor(const SolveOptions& options) : options_(options) {}
  explicit ProgressMonitor(SolveOptions&&) = delete;

  /// A new stage; false: stop.
  bool report(const std::string& stage, double fraction) {
    stage_ = stage;
    fraction_ = fraction;
    return go_on();
  }
  /// The stage of an adjustment of the arrivals that agree. @param round  from 0
  bool report_inliers(int round) {
    return report("adjustment of the arrivals that agree", std::min(0.9, 0.7 + 0.03 * round));
  }
  /// Within the stage.
  [[nodiscard]] bool go_on(int iteration = 0, double cost = 0.0) const {
    return !options_.on_progress || options_.on_progress({stage_, iteration, cost, fraction_});
  }
  /// Options of an adjustment that reports here and whose iterations are counted.
  [[nodiscard]] AdjustOptions adjust_options(double robust_scale, double function_tolerance) {
    AdjustOptions options;
    options.loss = {robust_scale, robust_scale};
    options.max_iterations = options_.max_iterations;
    options.workers = options_.workers();
    options.function_tolerance = function_tolerance;
    options.on_iteration = [this](int iteration, double cost) {
      ++iterations;
      return go_on(iteration, cost);
    };
    return options;
  }

  int iterations = 0;

 private:
  const SolveOptions& options_;
  std::string stage_;
  double fraction_ = 0.0;
};

}  // namespace octant::calib
