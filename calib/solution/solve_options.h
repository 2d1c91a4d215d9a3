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
  double fraction = 0.0;  ///< 0..1 of the whole, an estimate
};

struct SolveOptions {
  int threads = 1;
  const Ranks* ranks =
      nullptr;               ///< processes that solve this together, all given the same problem; not owned
  int max_iterations = 100;  ///< of each stage; the last, which comes to rest, may take four times as many
  double rejection_sigmas = 4.0;  ///< arrivals beyond this many sigmas are left out in the end
  int dense_limit = kDenseLimit;  ///< beyond so many shared parameters matrices are sparse
  bool strict = false;            ///< a single undetermined beacon refuses the whole
  /// Processor time of a diagnosis beyond three times that of the fit [s]. Infinite: all hypotheses are
  /// examined, and the findings do not depend on the speed of the machine.
  double diagnosis_s = 10.0;
  /// Called between iterations; returning false stops with SolveStatus::kInterrupted.
  std::function<bool(const Progress&)> on_progress = {};

  [[nodiscard]] Workers workers() const { return {threads, ranks}; }
  /// Whether the caller wants no more work.
  [[nodiscard]] bool is_stopped() const { return on_progress && !on_progress({}); }
};

}  // namespace octant::calib
