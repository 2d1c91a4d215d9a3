// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/support/scratch.h"
#include "models/trajectory/linearise.h"

namespace octant {

/// Factorisation of the block-tridiagonal information matrix of a segment's states (diagonal D, upper U),
///   L_k = D_k - U_{k-1}' L_{k-1}^-1 U_{k-1}
/// for fixed shared parameters and without rejected arrivals. For long segments see chain_windows.h.
struct ChainFactor {
  bool ok = false;                                 ///< false: the observations do not determine the states
  std::pmr::vector<NodeBlock> inverse{scratch()};  ///< L_k^-1
  std::pmr::vector<NodeBlock> U{scratch()};

  /// Overwrites the right-hand side (a vector or a block of columns for each node) with the solution.
  template <class Part>
  void solve(std::pmr::vector<Part>& x) const {
    for (std::size_t k = 1; k < x.size(); ++k) x[k] -= U[k - 1].transpose() * Part(inverse[k - 1] * x[k - 1]);
    for (std::size_t k = x.size(); k-- > 0;) {
      if (k + 1 < x.size()) x[k] -= U[k] * x[k + 1];
      x[k] = Part(inverse[k] * x[k]);
    }
  }
};
[[nodiscard]] ChainFactor factor_chain(const Trajectory& trajectory, const Segment& segment,
                                       const SharedState& state);

/// Eliminates the first `count` states of a system and stores their L_k^-1. The diagonal block of the next
/// state, if there is one, is updated to its Schur complement.
/// @return false if the observations do not determine one of the states
[[nodiscard]] bool eliminate_states(ChainSystem& system, std::size_t count,
                                    std::pmr::vector<NodeBlock>& inverse);

}  // namespace octant
