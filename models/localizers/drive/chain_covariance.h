// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/support/scratch.h"
#include "models/trajectory/linearise.h"

namespace octant {

/// The block-tridiagonal information matrix of a segment's states (diagonal D, upper U) in factors
///   L_k = D_k - U_{k-1}' L_{k-1}^-1 U_{k-1}
/// Shared parameters held, arrivals marked rejected left out.
struct ChainFactor {
  bool ok = false;                                 ///< false: the observations do not determine the states
  std::pmr::vector<NodeBlock> inverse{scratch()};  ///< L_k^-1
  std::pmr::vector<NodeBlock> U{scratch()};
  std::pmr::vector<NodeVector> gradient{scratch()};  ///< of half the sum of squares, where it was factored

  /// Overwrites the right-hand side, a vector or a block of columns a node, by the solution.
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

/// Marginal covariances of all states of a segment at once, in time linear in their number (node_covariance
/// costs as much for a single one).
struct ChainCovariance {
  bool ok = false;                  ///< false: the observations do not determine the states
  std::vector<NodeBlock> marginal;  ///< of each node
  std::vector<NodeBlock> cross;     ///< of node k (rows) and node k + 1 (columns)

  /// Covariance of the pose, of so many degrees of freedom, between node and node + 1, counted from the
  /// segment's first.
  [[nodiscard]] NodeBlock pose(std::size_t node, double alpha, int dof) const;
};

/// With the factors of the information matrix, backwards:
///   P_K = L_K^-1,  P_{k,k+1} = -L_k^-1 U_k P_{k+1},  P_k = L_k^-1 + L_k^-1 U_k P_{k+1} U_k' L_k^-1
/// (Rauch, Tung and Striebel's smoother in information form; sums of positive terms only.)
[[nodiscard]] ChainCovariance chain_covariance(const ChainFactor& factor);
[[nodiscard]] ChainCovariance chain_covariance(const Trajectory& trajectory, const Segment& segment,
                                               const SharedState& state);

}  // namespace octant
