// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "models/arrival_source.h"
#include "models/trajectory/state_kind.h"

namespace octant::calib {

/// A part of a run that is processed at once: the groups that begin in blocks [first_block, last_block). A
/// group consists of connected states of a vehicle, normally an epoch.
struct Chunk {
  std::size_t run = 0;
  std::size_t first_block = 0, last_block = 0;
  std::vector<std::size_t> states, arrivals;                ///< numbers of each vehicle
  std::vector<std::size_t> states_before, arrivals_before;  ///< in earlier chunks of the run
  [[nodiscard]] std::size_t all_arrivals() const;
};

/// For each run and each vehicle.
using StateKinds = std::vector<std::vector<StateKind>>;
[[nodiscard]] StateKinds state_kinds(const ArrivalSource& source, const Site& site);

/// Positions of the groups of a log among the blocks of its source, so that any part can be read as whole
/// groups. One pass over the log determines them; they are a few numbers for each block. Groups are epochs,
/// the arrivals of a vehicle between pauses that no connection of states outlasts (longest_tie_s), or all of
/// a run if odometry connects its stops. Drives are not included (drives/drive_index.h).
class ChunkIndex {
 public:
  /// Processes the rows of a source: add() of each block, then end(). Runs may be left out.
  /// @param chunk_arrivals  a chunk ends with the block in which it reaches this number
  ChunkIndex(StateKinds kinds, std::size_t beacons, std::size_t chunk_arrivals);
  void add(std::size_t run, const std::vector<Arrival>& block);
  void end(std::size_t runs);

  [[nodiscard]] const std::vector<Chunk>& chunks() const { return chunks_; }
  [[nodiscard]] const std::vector<StateKind>& kinds(std::size_t run) const { return kinds_[run]; }
  /// Epochs, or instants of arrivals.
  [[nodiscard]] std::size_t states(std::size_t run) const { return runs_[run].states; }
  [[nodiscard]] std::size_t arrivals() const { return arrivals_; }
  /// Arrivals of each beacon in a run.
  [[nodiscard]] const std::vector<std::size_t>& heard(std::size_t run) const { return runs_[run].heard; }
  [[nodiscard]] std::size_t blocks(std::size_t run) const { return runs_[run].first_state.size() - 1; }
  /// The number, in the order in which the states of all vehicles begin, of the first one that begins in a
  /// block.
  [[nodiscard]] std::size_t first_state(std::size_t run, std::size_t block) const {
    return runs_[run].first_state[block];
  }

  /// Replaces the content of `arrivals` by the arrivals of the groups that begin in blocks [first, last). Any
  /// thread may call it.
  [[nodiscard]] Result<void> read(const ArrivalSource& source, std::size_t run, std::size_t first,
                                  std::size_t last, std::vector<Arrival>& arrivals) const;

 private:
  /// A group that lies in several blocks.
  struct SplitGroup {
    std::size_t first_block = 0, last_block = 0;
    VehicleId vehicle;
    StateKind kind = StateKind::kStops;
    std::int64_t epoch = kNoEpoch;       ///< epoch of a stop
    double from_s = 0.0, until_s = 0.0;  ///< time span of other groups
    [[nodiscard]] bool has(const Arrival& a) const {
      if (a.vehicle != vehicle) return false;
      return kind == StateKind::kStops ? a.epoch == epoch : a.time_s >= from_s && a.time_s <= until_s;
    }
  };
  struct RunStates {
    std::size_t states = 0;
    std::vector<std::size_t> heard;
    std::vector<std::size_t> first_state;  ///< first state of each block, and the total
    std::vector<SplitGroup> splits;
    std::vector<std::uint32_t> open,
        first_open;  ///< splits across the beginning of each block: open[first_open[b]...first_open[b + 1])
  };
  /// The latest group of a vehicle.
  struct OpenGroup {
    bool any = false;
    std::int64_t epoch = kNoEpoch;          ///< epoch of its last row
    double time_s = 0.0;                    ///< of that
    double from_s = 0.0;                    ///< time of its first row
    std::size_t block = 0, chunk = 0;       ///< in which it began
    std::optional<std::size_t> split = {};  ///< where it lies in several
    [[nodiscard]] bool ends_state(StateKind kind, const Arrival& a) const;
    [[nodiscard]] bool ends(StateKind kind, const Arrival& a) const;
  };
  static void continue_group(RunStates& run, OpenGroup& open, StateKind kind, std::size_t block,
                             const Arrival& a);
  void begin_run();
  void begin_chunk(std::size_t block);
  void end_run();

  StateKinds kinds_;
  std::size_t vehicles_, beacons_, chunk_arrivals_;
  std::size_t chunk_size_ = 0;
  std::vector<OpenGroup> open_;  ///< open group of each vehicle
  std::vector<RunStates> runs_;
  std::vector<Chunk> chunks_;
  std::size_t arrivals_ = 0;
};

}  // namespace octant::calib
