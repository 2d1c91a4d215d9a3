// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/adjust/ranks.h"
#include "calib/stream/pass_sum.h"

namespace octant::calib {

/// Adds up what the chunks of a log give in the order of the chunks, whichever is ready first, so that no sum
/// depends on the number of threads.
class PassSummer {
 public:
  /// @param first  first chunk of this rank
  PassSummer(std::size_t first, int parameters) : in_order_(first) {
    sum_.system.H.setZero(parameters, parameters);
    sum_.system.gradient.setZero(parameters);
  }

  /// Solves for the trajectories of a chunk with plain squares, marks them as asked, and reduces them.
  /// @param limit  sigmas beyond which an arrival is rejected  @param of_chunk  scratch
  void add(std::size_t chunk, std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
           const SharedState& state, double limit, RejectionPolicy policy, PassSum& of_chunk);

  /// The sum over the chunks of all ranks.
  [[nodiscard]] PassSum sum(const Ranks* ranks) &&;

 private:
  OrderedParts<PassSum> in_order_;
  PassSum sum_;
};

}  // namespace octant::calib
