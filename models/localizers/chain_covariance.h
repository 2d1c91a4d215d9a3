// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/linearise.h"

namespace octant {

/// Marginal covariances of all states of a segment at once, in time linear in their number (node_covariance costs as much for
/// a single one). Shared parameters held, arrivals marked rejected left out.
struct ChainCovariance {
  bool ok = false;                  ///< false: the observations do not determine the states
  std::vector<NodeBlock> marginal;  ///< of each node
  std::vector<NodeBlock> cross;     ///< of node k (rows) and node k + 1 (columns)

  /// Covariance of the pose between node and node + 1 of a planar segment, counted from the segment's first.
  [[nodiscard]] Eigen::MatrixXd planar_pose(std::size_t node, double alpha) const;
};

/// With the forward factors L_k = D_k - U_{k-1}' L_{k-1}^-1 U_{k-1} of the block-tridiagonal information matrix, backwards:
///   P_K = L_K^-1,  P_{k,k+1} = -L_k^-1 U_k P_{k+1},  P_k = L_k^-1 + L_k^-1 U_k P_{k+1} U_k' L_k^-1
/// (Rauch, Tung and Striebel's smoother in information form; sums of positive terms only.)
[[nodiscard]] ChainCovariance chain_covariance(const Trajectory& trajectory, const Segment& segment, const SharedState& state);

}  // namespace octant
