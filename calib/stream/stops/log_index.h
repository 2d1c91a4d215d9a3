// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "models/arrival_source.h"

namespace octant::calib {

/// A stretch of a run that is worked on at once: the epochs that begin in blocks [first_block, last_block).
struct LogChunk {
  std::size_t run = 0;
  std::size_t first_block = 0, last_block = 0;
  std::vector<std::size_t> epochs, arrivals;                ///< of each vehicle
  std::vector<std::size_t> epochs_before, arrivals_before;  ///< in earlier chunks of the run
  [[nodiscard]] std::size_t all_arrivals() const;
};

/// Where the epochs of a log lie among the blocks of its source, so that any stretch of it can be read as
/// whole epochs. What one reading of everything tells; a few numbers a block.
class LogIndex {
 public:
  /// Follows the rows of a source: take() of each block, then end(). Runs may be left out.
  /// @param chunk_arrivals  a chunk ends with the block in which it has as many
  LogIndex(std::size_t vehicles, std::size_t beacons, std::size_t chunk_arrivals);
  LogIndex(LogIndex&&) noexcept;
  ~LogIndex();
  void take(std::size_t run, const std::vector<Arrival>& block);
  void end(std::size_t runs);

  [[nodiscard]] const std::vector<LogChunk>& chunks() const { return chunks_; }
  [[nodiscard]] std::size_t epochs(std::size_t run) const { return runs_[run].epochs; }
  [[nodiscard]] std::size_t all_epochs() const;
  [[nodiscard]] std::size_t arrivals() const { return arrivals_; }
  /// Arrivals of each beacon in a run.
  [[nodiscard]] const std::vector<std::size_t>& heard(std::size_t run) const { return runs_[run].heard; }
  [[nodiscard]] std::size_t blocks(std::size_t run) const { return runs_[run].first_epoch.size() - 1; }
  /// The number, in the order in which the epochs of all vehicles begin, of the first one that begins in a
  /// block.
  [[nodiscard]] std::size_t first_epoch(std::size_t run, std::size_t block) const {
    return runs_[run].first_epoch[block];
  }

  /// Puts the arrivals of the epochs that begin in blocks [first, last) in place of what `arrivals` held. Any
  /// thread.
  [[nodiscard]] Result<void> read(const ArrivalSource& source, std::size_t run, std::size_t first,
                                  std::size_t last, std::vector<Arrival>& arrivals) const;

 private:
  /// An epoch that lies in several blocks.
  struct Split {
    std::size_t first_block = 0, last_block = 0;
    VehicleId vehicle;
    std::int64_t epoch = kNoEpoch;
  };
  struct Run {
    std::size_t epochs = 0;
    std::vector<std::size_t> heard;
    std::vector<std::size_t> first_epoch;  ///< of each block, and one more
    std::vector<Split> splits;
    std::vector<std::uint32_t> open,
        first_open;  ///< splits across the beginning of each block: open[first_open[b]...first_open[b + 1])
  };
  class Scanner;

  std::unique_ptr<Scanner> scanner_;  ///< until the end
  std::vector<Run> runs_;
  std::vector<LogChunk> chunks_;
  std::size_t arrivals_ = 0;
};

}  // namespace octant::calib
