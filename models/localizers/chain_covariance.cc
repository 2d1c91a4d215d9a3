// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain_covariance.h"

#include <Eigen/Cholesky>

namespace octant {

Eigen::MatrixXd ChainCovariance::planar_pose(std::size_t node, double alpha) const {
  if (alpha == 0.0 || node + 1 >= marginal.size()) return marginal[node].topLeftCorner(3, 3);
  const NodeBlock P = (1 - alpha) * (1 - alpha) * marginal[node] + alpha * alpha * marginal[node + 1] +
                      alpha * (1 - alpha) * (cross[node] + cross[node].transpose());
  return P.topLeftCorner(3, 3);
}

ChainCovariance chain_covariance(const Trajectory& trajectory, const Segment& segment, const SharedState& state) {
  ChainCovariance out;
  ChainSystem system;
  build_chain_system(trajectory, segment, state, RobustLoss{}, system);
  const std::size_t count = system.D.size();
  if (count == 0) return out;
  const int n = trajectory.block_size();
  std::vector<NodeBlock> inverse(count);  // L_k^-1
  NodeBlock L = system.D[0];
  for (std::size_t k = 0; k < count; ++k) {
    if (k > 0) L = system.D[k] - system.U[k - 1].transpose() * inverse[k - 1] * system.U[k - 1];
    // Elements differ by the squares of metres and radians: judged with a unit diagonal.
    const NodeVector scale = L.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const NodeBlock scaled = scale.asDiagonal() * L * scale.asDiagonal();
    const Eigen::LDLT<NodeBlock> ldlt(scaled);
    if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 1e-12)) return out;
    const NodeBlock unscaled = ldlt.solve(NodeBlock::Identity(n, n));
    inverse[k] = scale.asDiagonal() * unscaled * scale.asDiagonal();
  }
  out.marginal.resize(count);
  out.cross.resize(count - 1);
  out.marginal[count - 1] = inverse[count - 1];
  for (std::size_t k = count - 1; k-- > 0;) {
    const NodeBlock gain = inverse[k] * system.U[k];
    out.cross[k] = -gain * out.marginal[k + 1];
    out.marginal[k] = inverse[k] + gain * out.marginal[k + 1] * gain.transpose();
  }
  out.ok = true;
  return out;
}

}  // namespace octant
