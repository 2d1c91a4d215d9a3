// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/trajectory/linearise.h"

namespace octant {

/// An instant on a drive, between node and node + 1 of a trajectory.
struct DriveInstant {
  std::size_t node = 0;
  double alpha = 0.0;
};

/// Part of the states of a chain, given all observations of the chain.
struct ChainWindow {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  std::size_t first_node = 0, last_node = 0;  ///< [first, last)
  std::vector<NodeBlock>
      marginal;  ///< covariance of each node, and of the next one behind the window if there is one
  std::vector<NodeBlock> cross;  ///< cross-covariance of node k (rows) and node k + 1 (columns)
  Matrix solution;               ///< rows: components of the states, node by node; columns: right-hand sides

  /// Covariance of the first `dof` components of the state at an instant from node first to last - 1.
  [[nodiscard]] NodeBlock covariance_at(const DriveInstant& instant, int dof) const;
  /// Solution at an instant (dof x columns).
  [[nodiscard]] Matrix solution_at(const DriveInstant& instant, int dof) const;
};

/// Calls visit(index) for the instants inside a window.
/// @param instants  instants of a drive, in order of nodes
template <class Visit>
void for_each_instant(const ChainWindow& window, std::span<const DriveInstant> instants, Visit&& visit) {
  auto at = std::partition_point(instants.begin(), instants.end(),
                                 [&](const DriveInstant& i) { return i.node < window.first_node; });
  for (; at != instants.end() && at->node < window.last_node; ++at)
    visit(static_cast<std::size_t>(at - instants.begin()));
}

/// A chain with all of its arrivals or without those of one beacon, and the quantities to compute.
struct ChainVariant {
  BeaconId without;  ///< invalid: all arrivals are used
  Eigen::Index columns = 0;
  /// Errors of each row, one for each column; returns false for a row without errors. The right-hand side of
  /// errors e is J' e.
  std::function<bool(const ObservationRow& row, Eigen::RowVectorXd& errors)> errors_of = {};
  std::function<void(const ChainWindow&)> visit =
      {};  ///< called for each window, the last one of the chain first
};

/// Solves the normal equations H x = J' e of a segment's states and computes their marginal covariances. The
/// cost is linear in the number of states, and memory is needed for one window of states only. The forward
/// pass eliminates
///   L_k = D_k - U_{k-1}' L_{k-1}^-1 U_{k-1}
/// and keeps the terms that enter each window. The backward pass factors each window again and substitutes
///   P_K = L_K^-1,  P_{k,k+1} = -L_k^-1 U_k P_{k+1},  P_k = L_k^-1 + L_k^-1 U_k P_{k+1} U_k' L_k^-1
/// (smoother of Rauch, Tung and Striebel in information form; all sums have positive terms). Up to rounding
/// the result does not depend on the windows. Rows are linearised once for all variants. Shared parameters
/// are fixed and rejected arrivals are not used.
/// @param window_nodes  number of states in a window
/// @return for each variant, true if its observations determine all states; windows of the others are not
/// visited
[[nodiscard]] std::vector<bool> solve_by_windows(const Trajectory& trajectory, const Segment& segment,
                                                 const SharedState& state,
                                                 std::span<const ChainVariant> variants, int threads = 1,
                                                 std::size_t window_nodes = 512);

}  // namespace octant
