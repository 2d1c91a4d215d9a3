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

/// A place on a drive: between node and node + 1 of a trajectory.
struct DriveInstant {
  std::size_t node = 0;
  double alpha = 0.0;
};

/// Some states of a chain as all of its observations have them.
struct ChainWindow {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  std::size_t first_node = 0, last_node = 0;  ///< [first, last)
  std::vector<NodeBlock> marginal;  ///< covariance of each node, and of the one behind them if there is one
  std::vector<NodeBlock> cross;     ///< of node k (rows) and node k + 1 (columns)
  Matrix solution;                  ///< as many rows a node as its state has, a column a right-hand side

  /// Covariance of the first `dof` of a state's components at an instant from node first to last - 1.
  [[nodiscard]] NodeBlock covariance_at(const DriveInstant& instant, int dof) const;
  /// Of the solution (dof x columns).
  [[nodiscard]] Matrix solution_at(const DriveInstant& instant, int dof) const;
};

/// Calls visit(index) for the instants that a window holds.
/// @param instants  of a drive, in order of nodes
template <class Visit>
void for_each_instant(const ChainWindow& window, std::span<const DriveInstant> instants, Visit&& visit) {
  auto at = std::partition_point(instants.begin(), instants.end(),
                                 [&](const DriveInstant& i) { return i.node < window.first_node; });
  for (; at != instants.end() && at->node < window.last_node; ++at)
    visit(static_cast<std::size_t>(at - instants.begin()));
}

/// A chain with all of its arrivals or without those of one beacon, and what is asked of it.
struct ChainVariant {
  BeaconId without;  ///< invalid: all are in
  Eigen::Index columns = 0;
  /// An error of each row, one for each column; a row that has none is false. The right-hand side of errors e
  /// is J' e.
  std::function<bool(const ObservationRow& row, Eigen::RowVectorXd& errors)> errors_of = {};
  std::function<void(const ChainWindow&)> visit = {};  ///< window by window, the last of the chain first
};

/// Solves the normal equations H x = J' e of a segment's states and gives the marginal covariances, in time
/// linear in their number and in memory that hardly grows with it: of a window of states at a time. Forwards
///   L_k = D_k - U_{k-1}' L_{k-1}^-1 U_{k-1}
/// of which what each window gets from those before it is kept; then backwards, where a window is factored
/// again from there,
///   P_K = L_K^-1,  P_{k,k+1} = -L_k^-1 U_k P_{k+1},  P_k = L_k^-1 + L_k^-1 U_k P_{k+1} U_k' L_k^-1
/// (Rauch, Tung and Striebel's smoother in information form; sums of positive terms only.) The result does
/// not depend on where windows end but for rounding. Rows are linearised once for all variants. Shared
/// parameters are held, arrivals marked rejected left out.
/// @param window_nodes  states of a window
/// @return for each variant whether its observations determine all states; windows of others are not visited
[[nodiscard]] std::vector<bool> solve_by_windows(const Trajectory& trajectory, const Segment& segment,
                                                 const SharedState& state,
                                                 std::span<const ChainVariant> variants, int threads = 1,
                                                 std::size_t window_nodes = 512);

}  // namespace octant
