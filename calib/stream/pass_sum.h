// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "calib/adjust/tile.h"
#include "calib/errors/statistics.h"

namespace octant::calib {

/// What one reading of a log leaves of it at an estimate.
struct PassSum {
  ReducedSystem system;      ///< of all arrivals in use, plain squares; its cost is theirs
  double cost_before = 0.0;  ///< with the marks as they were before the pass
  std::size_t changed = 0;   ///< marks
  ObservationCounts counts;  ///< without residuals
};

/// Which arrivals a pass rejects anew.
enum class MarkPolicy {
  kKept,    ///< none
  kFirst,   ///< rejected at the states as they are, which are settled then
  kSettled  ///< rejected at settled states, which are settled again where marks changed
};

/// Systems of chunks, added up in their order, whoever is first.
class OrderedSum {
 public:
  OrderedSum(std::size_t first, int size) : next_(first) {
    sum_.H.setZero(size, size);
    sum_.gradient.setZero(size);
  }
  void add(std::size_t chunk, const ReducedSystem& system) {
    const std::lock_guard lock(mutex_);
    if (chunk != next_) {
      waiting_.emplace(chunk, system);
      return;
    }
    take(system);
    for (auto at = waiting_.find(next_); at != waiting_.end(); at = waiting_.find(next_)) {
      take(at->second);
      waiting_.erase(at);
    }
  }
  ReducedSystem sum() && { return std::move(sum_); }

 private:
  void take(const ReducedSystem& system) {
    sum_.cost += system.cost;
    sum_.H += system.H;
    sum_.gradient += system.gradient;
    ++next_;
  }
  std::mutex mutex_;
  std::size_t next_;
  ReducedSystem sum_;
  std::map<std::size_t, ReducedSystem> waiting_;
};

/// Adds up what the chunks of a log give: systems in the order of the chunks, whichever is ready first, so
/// that no sum depends on the number of threads.
class PassSummer {
 public:
  /// @param first  first chunk of this rank  @param chunks  of all ranks
  PassSummer(std::size_t first, std::size_t chunks, int parameters)
      : systems_(first, parameters), numbers_(chunks) {}

  /// Settles the trajectories of a chunk with plain squares, marks them as asked, and reduces them.
  /// @param limit  sigmas beyond which an arrival is rejected  @param system  scratch
  void take(std::size_t chunk, std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
            const SharedState& state, double limit, MarkPolicy marks, ReducedSystem& system);

  /// All numbers one behind the other, to be added up over the ranks, and back.
  [[nodiscard]] std::vector<double> numbers() &&;
  [[nodiscard]] static PassSum sum_of(const std::vector<double>& numbers, Eigen::Index parameters);

 private:
  struct Numbers {
    double cost = 0.0, cost_before = 0.0, changed = 0.0;
    ObservationCounts counts;
  };
  OrderedSum systems_;
  std::vector<Numbers> numbers_;
};

}  // namespace octant::calib
