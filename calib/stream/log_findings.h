// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "calib/errors/statistics.h"
#include "calib/errors/whiteness.h"
#include "calib/problem/log_tape.h"
#include "calib/problem/whole_log.h"
#include "calib/start/approach.h"
#include "calib/stream/chunk_work.h"
#include "calib/stream/log_index.h"
#include "calib/stream/log_readings.h"
#include "models/arrival_source.h"

namespace octant::calib {

/// Gathers the findings of a log chunk by chunk: what a chunk has to say is written as numbers, those of all
/// chunks and ranks stand one behind the other, and are read back from there in the order of the chunks.
class FindingsGatherer {
 public:
  /// All but the estimate must outlive it.
  FindingsGatherer(const Problem& frame, const ArrivalSource& source, const LogIndex& index,
                   const TrajectoryModel& model, const Estimate& estimate);

  /// Appends a chunk's numbers; several threads may write side by side.
  void write(const ChunkWork& w, const ChunkStops& stops, std::size_t chunk,
             std::vector<double>& numbers) const;
  /// Reads the numbers of all chunks.
  void read(const std::vector<double>& numbers);
  [[nodiscard]] LogFindings findings(const Estimate& estimate) &&;

 private:
  /// Of a run and a vehicle.
  struct OfTrajectory {
    std::vector<PairSeries> series;
    std::vector<std::int64_t> flipped;
    std::vector<Arrival> arrivals;  ///< of the epochs at hand
    std::vector<Rejection> marks;
    std::vector<std::array<double, 3>> pose;
  };

  void write_counts(const Trajectory& t, TapeWriter& tape) const;
  void write_series(const Trajectory& t, TapeWriter& tape) const;
  void write_some_epochs(const ChunkWork& w, const Trajectory& t, TapeWriter& tape) const;
  void read_trajectory(std::size_t run, std::size_t vehicle, TapeReader& tape);
  static void read_epoch(std::size_t vehicle, OfTrajectory& of, TapeReader& tape);
  /// The epochs at hand as a trajectory, as the whole would be one.
  Trajectory trajectory_of(std::size_t run, std::size_t vehicle, OfTrajectory& of);

  const Problem& frame_;
  const ArrivalSource& source_;
  const LogIndex& index_;
  const TrajectoryModel& model_;
  const Site& site_;
  SharedState state_;
  double sigma_s_;
  WholeLog whole_;
  ObservationCounts counts_;
  std::map<std::pair<std::size_t, std::size_t>, OfTrajectory> of_trajectory_;
  LogFindings findings_;
};

}  // namespace octant::calib
