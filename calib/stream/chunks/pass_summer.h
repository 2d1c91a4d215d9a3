// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "calib/stream/pass_sum.h"

namespace octant::calib {

/// Adds up what the chunks of a log give: systems in the order of the chunks, whichever is ready first, so
/// that no sum depends on the number of threads.
class PassSummer {
 public:
  /// @param first  first chunk of this rank  @param chunks  of all ranks
  PassSummer(std::size_t first, std::size_t chunks, int parameters) : systems_(first), chunks_(chunks) {
    sum_.H.setZero(parameters, parameters);
    sum_.gradient.setZero(parameters);
  }

  /// Solves for the trajectories of a chunk with plain squares, marks them as asked, and reduces them.
  /// @param limit  sigmas beyond which an arrival is rejected  @param system  scratch
  void add(std::size_t chunk, std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
           const SharedState& state, double limit, RejectionPolicy policy, ReducedSystem& system);

  /// All numbers one behind the other, to be added up over the ranks, and back.
  [[nodiscard]] std::vector<double> numbers() &&;
  [[nodiscard]] static PassSum sum_of(const std::vector<double>& numbers, Eigen::Index parameters);

 private:
  struct Chunk {
    double cost = 0.0;  ///< of solved states, as PassCounts know it with the rejections as they were
    PassCounts counts;
  };
  OrderedParts<ReducedSystem> systems_;
  ReducedSystem sum_;
  std::vector<Chunk> chunks_;
};

}  // namespace octant::calib
