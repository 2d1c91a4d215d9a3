// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "calib/stream/chunks/chunk_index.h"
#include "calib/stream/chunks/state_bearings.h"
#include "calib/stream/kept_states.h"
#include "calib/stream/log_readings.h"

namespace octant::calib {

/// How much of a log is at hand at once. The chunks depend on the memory alone, so that no sum depends on the
/// number of threads.
struct StreamPlan {
  std::size_t chunk_arrivals = 0;
  std::size_t piece_bytes = 0;  ///< of drives, instead
  int workers = 1;              ///< chunks worked on side by side
};
[[nodiscard]] StreamPlan stream_plan(std::size_t memory_bytes, int threads);

/// A chunk of a log that a worker has at hand.
struct ChunkWork {
  const Chunk* chunk = nullptr;
  MeasurementLog log;
  std::vector<Trajectory> trajectories;
  PassSum sum;  ///< of the chunk alone
};

/// What remains of a chunk between the readings.
struct KeptChunk {
  std::vector<KeptTrajectory> trajectories;
  std::vector<float> start_heading_rad;
};

/// The states of a log but for drives, read again for each look at them, chunk by chunk on several threads.
/// Between the readings there remains where each state is (28 bytes of a stop in the plane) and what became
/// of each arrival (one byte); ranks keep those of their own chunks and read no others.
class ChunkPasses : public LogReadings {
 public:
  ChunkPasses(const ReadingTask& task, const ChunkIndex& index);

  /// See place_all.
  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool reject) override;
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, RejectionPolicy policy) override;
  /// Looked at one by one are every so many-th epoch or moment, and stretches of what hangs together.
  [[nodiscard]] Result<void> gather(const Estimate& estimate, FindingsGatherer& gatherer) override;

 private:
  template <class Do>
  Result<void> for_each_chunk_of_mine(Do&& work);
  Result<void> load(std::size_t chunk, ChunkWork& w) const;
  [[nodiscard]] bool is_as_before(std::size_t chunk, const ChunkWork& w) const;
  void restore(const KeptChunk& kept, const Estimate& estimate, ChunkWork& w) const;
  static void keep(const ChunkWork& w, KeptChunk& kept);
  void gather_trajectory(const ChunkWork& w, const Trajectory& t, const float* start_heading_rad,
                         const FindingsGatherer& gatherer, std::vector<double>& buffer) const;

  ReadingTask task_;
  const ChunkIndex& index_;
  TrajectoryModel model_;
  std::size_t first_, last_;             ///< chunks of this rank
  std::vector<StateBearings> bearings_;  ///< of each run
  std::vector<std::unique_ptr<ChunkWork>> workers_;
  std::vector<KeptChunk> kept_;  ///< of each chunk
};

}  // namespace octant::calib
