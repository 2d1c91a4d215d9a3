// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <mutex>
#include <utility>

#include "calib/adjust/tile.h"
#include "calib/errors/statistics.h"

namespace octant::calib {

/// What is counted in one reading of a log, by piece, by rank and in all.
struct PassCounts {
  double cost_before = 0.0;  ///< with the rejections as they were before the pass
  std::size_t changed = 0;   ///< marks
  ObservationCounts of_log;  ///< without residuals
  static constexpr int kSize = 6;

  void add(const PassCounts& other) {
    cost_before += other.cost_before;
    changed += other.changed;
    of_log.add(other.of_log);
  }
  /// As ranks add them up.
  [[nodiscard]] std::array<double, kSize> as_numbers() const {
    return {cost_before,
            static_cast<double>(changed),
            static_cast<double>(of_log.used),
            static_cast<double>(of_log.rejected),
            of_log.observations,
            static_cast<double>(of_log.states)};
  }
  /// @param numbers  kSize of them, as of as_numbers()
  static PassCounts from_numbers(const double* numbers) {
    PassCounts counts;
    counts.cost_before = numbers[0];
    counts.changed = static_cast<std::size_t>(numbers[1]);
    counts.of_log.used = static_cast<std::size_t>(numbers[2]);
    counts.of_log.rejected = static_cast<std::size_t>(numbers[3]);
    counts.of_log.observations = numbers[4];
    counts.of_log.states = static_cast<std::size_t>(numbers[5]);
    return counts;
  }
};

/// What one reading of a log leaves of it at an estimate.
struct PassSum {
  ReducedSystem system;  ///< of all arrivals in use, plain squares; its cost is theirs
  PassCounts counts;

  void add(const PassSum& other) {
    system.cost += other.system.cost;
    system.H += other.system.H;
    system.gradient += other.system.gradient;
    counts.add(other.counts);
  }
};

/// Which arrivals a pass rejects anew.
enum class RejectionPolicy {
  kKept,      ///< none
  kFirst,     ///< rejected at the states as they are, which are solved then
  kConverged  ///< rejected at solved states, which are solved again where rejections changed
};

/// Takes what the parts of a log give in the order of the parts, whichever is ready first, so that no sum
/// depends on the number of threads.
template <class Value>
class OrderedParts {
 public:
  explicit OrderedParts(std::size_t first) : next_(first) {}
  /// Calls take(part, value) as soon as it is a part's turn.
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
