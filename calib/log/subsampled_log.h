// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/log/held_log.h"

namespace octant::calib {

/// Observations of a log, each kind for itself.
struct LogCounts {
  std::vector<double> arrivals, bearings;  ///< by beacon
  double poses = 0.0;
  std::size_t states = 0;

  explicit LogCounts(const Problem& problem);
  [[nodiscard]] double all_arrivals() const;
};

/// A subsampled log (problem/subsample.h) in memory whose verdict is that of the whole log: each observation
/// is as accurate as all those together that it represents. Other quantities are judged unchanged, because
/// residuals of few arrivals are not as informative as those of all.
class SubsampledLog : public HeldLog {
 public:
  /// All outlive it.
  SubsampledLog(const Problem& subsampled, const LogCounts& whole, const SolveOptions& options,
                ProgressMonitor& monitor)
      : HeldLog(subsampled, options, monitor), whole_(whole) {}

  [[nodiscard]] Result<Findings> findings(const Estimate& estimate) override;

 private:
  const LogCounts& whole_;
};

}  // namespace octant::calib
