// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/chain_covariance.h"

#include <utility>

#include "models/support/observed.h"

namespace octant {

NodeBlock ChainCovariance::pose(std::size_t node, double alpha, int dof) const {
  if (alpha == 0.0 || node + 1 >= marginal.size()) return marginal[node].topLeftCorner(dof, dof);
  const NodeBlock P = (1 - alpha) * (1 - alpha) * marginal[node] + alpha * alpha * marginal[node + 1] +
                      alpha * (1 - alpha) * (cross[node] + cross[node].transpose());
  return P.topLeftCorner(dof, dof);
}

ChainFactor factor_chain(const Trajectory& trajectory, const Segment& segment, const SharedState& state) {
  ChainFactor out;
  ChainSystem system;
  build_chain_system(trajectory, segment, state, RobustLoss{}, system);
  const std::size_t count = system.D.size();
  out.inverse.resize(count);
  // What no arrival tells of the attitude (a single antenna's about a straight path) is any angle.
  if (trajectory.motion == Motion::kSpatial) add_vague_angles(trajectory.motion, system.D[0]);
  NodeBlock L;
  for (std::size_t k = 0; k < count; ++k) {
    L = system.D[k];
    if (k > 0) L -= system.U[k - 1].transpose() * out.inverse[k - 1] * system.U[k - 1];
    const ObservedState<NodeBlock> observed(L);
    if (!observed.all()) return out;
    out.inverse[k] = observed.covariance();
  }
  out.U = std::move(system.U);
  out.gradient = std::move(system.g);
  out.ok = count > 0;
  return out;
}

ChainCovariance chain_covariance(const ChainFactor& factor) {
  ChainCovariance out;
  if (!factor.ok) return out;
  const std::size_t count = factor.inverse.size();
  out.marginal.resize(count);
  out.cross.resize(count - 1);
  out.marginal[count - 1] = factor.inverse[count - 1];
  for (std::size_t k = count - 1; k-- > 0;) {
    const NodeBlock gain = factor.inverse[k] * factor.U[k];
    out.cross[k] = -gain * out.marginal[k + 1];
    out.marginal[k] = factor.inverse[k] + gain * out.marginal[k + 1] * gain.transpose();
  }
  out.ok = true;
  return out;
}

ChainCovariance chain_covariance(const Trajectory& trajectory, const Segment& segment,
                                 const SharedState& state) {
  return chain_covariance(factor_chain(trajectory, segment, state));
}

}  // namespace octant
