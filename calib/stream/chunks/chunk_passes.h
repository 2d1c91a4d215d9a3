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

/// Amount of a log in memory at a time. The chunks depend on the memory only, so no sum depends on the number
/// of threads.
struct StreamPlan {
  std::size_t chunk_arrivals = 0;
  std::size_t piece_bytes = 0;  ///< bytes of a piece of a drive
  int workers = 1;              ///< chunks worked on side by side
};
[[nodiscard]] StreamPlan stream_plan(std::size_t memory_bytes, int threads);

/// A chunk of a log that a worker processes.
struct ChunkWork {
  const Chunk* chunk = nullptr;
  MeasurementLog log;
  std::vector<Trajectory> trajectories;
  PassSum sum;  ///< sum of this chunk
};

/// Data of a chunk that are kept between passes.
struct KeptChunk {
  std::vector<KeptTrajectory> trajectories;
  std::vector<float> start_heading_rad;
};

/// All states of a log except drives, read in each pass, chunk by chunk on several threads. Between the
/// passes, the position of each state (28 bytes of a stop in the plane) and the fate of each arrival (one
/// byte) are kept. Each rank keeps and reads its own chunks only.
class ChunkPasses : public LogReadings {
 public:
  ChunkPasses(const ReadingTask& task, const ChunkIndex& index);

  /// See place_all.
  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool reject) override;
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, RejectionPolicy policy) override;
  /// The sample consists of evenly spaced epochs or moments, and of segments of connected states.
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
  std::vector<StateBearings> bearings_;  ///< bearings of each run
  std::vector<std::unique_ptr<ChunkWork>> workers_;
  std::vector<KeptChunk> kept_;  ///< kept data of each chunk
};

}  // namespace octant::calib
