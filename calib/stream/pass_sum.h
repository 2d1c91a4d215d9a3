// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <mutex>

#include "calib/errors/statistics.h"
#include "calib/sums/log_buffer.h"
#include "calib/sums/reduced_system.h"

namespace octant::calib {

/// Counts of one pass over a log, for a piece, a rank, or all.
struct PassCounts {
  double cost_before = 0.0;  ///< with the rejections before the pass
  std::size_t changed = 0;   ///< marks
  ObservationCounts of_log;  ///< without residuals
  PoseSquares poses;

  void add(const PassCounts& other) {
    cost_before += other.cost_before;
    changed += other.changed;
    of_log.add(other.of_log);
    poses.add(other.poses);
  }
};
/// As ranks add them up.
template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<PassCounts> auto&& counts) {
  buffer.exchange(counts.cost_before, counts.changed, counts.of_log.used, counts.of_log.rejected,
                  counts.of_log.observations, counts.of_log.states, counts.poses.squares,
                  counts.poses.redundancy, counts.poses.other_squares, counts.poses.other_redundancy);
}

/// Result of one pass over a log at an estimate.
struct PassSum {
  SystemParts system;  ///< system and cost of all used arrivals, plain squares
  PassCounts counts;

  void add(const PassSum& other) {
    system.add(other.system);
    counts.add(other.counts);
  }
};

/// Rule by which a pass rejects arrivals.
enum class RejectionPolicy {
  kKept,      ///< rejections are unchanged
  kFirst,     ///< rejected at the present states, which are then solved
  kConverged  ///< rejected at solved states, which are solved again where rejections changed
};

/// Processes the results of the parts of a log in the order of the parts, for any order of completion, so
/// that no sum depends on the number of threads.
template <class Value>
class OrderedParts {
 public:
  explicit OrderedParts(std::size_t first) : next_(first) {}
  /// Calls take(part, value) when all previous parts are complete.
  template <class Take>
  void add(std::size_t part, const Value& value, Take&& take) {
    const std::lock_guard lock(mutex_);
    if (part != next_) {
      waiting_.emplace(part, value);
      return;
    }
    take(next_++, value);
    for (auto at = waiting_.find(next_); at != waiting_.end(); at = waiting_.find(next_)) {
      take(next_++, at->second);
      waiting_.erase(at);
    }
  }

 private:
  std::mutex mutex_;
  std::size_t next_;
  std::map<std::size_t, Value> waiting_;
};

}  // namespace octant::calib
