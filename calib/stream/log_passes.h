// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "calib/start/approach.h"
#include "calib/stream/chunk_work.h"
#include "calib/stream/log_findings.h"
#include "calib/stream/log_index.h"
#include "calib/stream/log_readings.h"
#include "calib/stream/pass_sum.h"
#include "models/arrival_source.h"

namespace octant::calib {

/// How much of a log is at hand at once. The chunks depend on the memory alone, so that no sum depends on the
/// number of threads.
struct StreamPlan {
  std::size_t chunk_arrivals = 0;
  std::size_t piece_bytes = 0;  ///< of drives, instead
  int workers = 1;              ///< chunks worked on side by side
};
[[nodiscard]] StreamPlan stream_plan(std::size_t memory_bytes, int threads);

/// A log of stops that is read again for each look at it, chunk by chunk on several threads. Between the
/// readings there remains where each stop is (28 bytes) and what became of each arrival (one byte); ranks
/// keep those of their own chunks and read no others.
class LogPasses : public LogReadings {
 public:
  /// All must outlive it. @param frame  site and runs without arrivals
  LogPasses(const Problem& frame, const ArrivalSource& source, const LogIndex& index,
            const SolveOptions& options, int workers, Course& course);

  /// See place_all_stops.
  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool mark) override;
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, MarkPolicy marks) override;
  /// Every so many-th epoch to look at.
  [[nodiscard]] Result<LogFindings> findings(const Estimate& estimate) override;

 private:
  template <class Do>
  Result<void> for_each_chunk_of_mine(Do&& work);
  Result<void> load(std::size_t chunk, ChunkWork& w) const;
  void restore(const ChunkStops& stops, double sigma_s, ChunkWork& w) const;
  void keep(const ChunkWork& w, ChunkStops& stops) const;
  void add_up(std::vector<double>& numbers) const;
  [[nodiscard]] std::vector<double> in_order(std::vector<std::vector<double>> of_chunks) const;

  const Problem& frame_;
  const ArrivalSource& source_;
  const LogIndex& index_;
  const SolveOptions& options_;
  Course& course_;
  TrajectoryModel model_;
  std::size_t first_, last_;  ///< chunks of this rank
  std::vector<std::unique_ptr<ChunkWork>> workers_;
  std::vector<ChunkStops> stops_;  ///< of each chunk
};

}  // namespace octant::calib
