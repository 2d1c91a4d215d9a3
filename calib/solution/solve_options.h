// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "calib/problem/parameters.h"
#include "calib/sums/ranks.h"

namespace octant::calib {

/// Progress of a calibration: stage in words, iteration within it, cost.
struct Progress {
  std::string stage;
  int iteration = 0;
  double cost = 0.0;
  double fraction = 0.0;  ///< estimated fraction of the whole, 0..1
};

struct SolveOptions {
  int threads = 1;
  const Ranks* ranks = nullptr;  ///< processes that solve the same problem together; not owned
  /// Iterations of each stage; the last one, which converges, may take four times as many
  int max_iterations = 100;
  double rejection_sigmas = 4.0;  ///< arrivals beyond this number of sigmas are rejected at the end
  int dense_limit = kDenseLimit;  ///< number of shared parameters beyond which matrices are sparse
  bool strict = false;            ///< a single undetermined beacon refuses the calibration
  /// Processor time of a diagnosis beyond three times that of the fit [s]. Infinite: all hypotheses are
  /// examined, and the findings do not depend on the speed of the machine.
  double diagnosis_s = 10.0;
  /// Called between iterations; returning false stops with SolveStatus::kInterrupted.
  std::function<bool(const Progress&)> on_progress = {};

  [[nodiscard]] Workers workers() const { return {threads, ranks}; }
  /// Returns true if the caller requests an end.
  [[nodiscard]] bool is_stopped() const { return on_progress && !on_progress({}); }
};

}  // namespace octant::calib
