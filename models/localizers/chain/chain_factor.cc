// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain/chain_factor.h"

#include <utility>

#include "models/support/observed.h"

namespace octant {

bool eliminate_states(ChainSystem& system, std::size_t count, std::pmr::vector<NodeBlock>& inverse) {
  inverse.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    const ObservedState<NodeBlock> observed(system.D[k]);
    if (!observed.all()) return false;
    inverse[k] = observed.covariance();
    if (k + 1 < system.D.size()) system.D[k + 1] -= system.U[k].transpose() * inverse[k] * system.U[k];
  }
  return true;
}

ChainFactor factor_chain(const Trajectory& trajectory, const Segment& segment, const SharedState& state) {
  ChainFactor out;
  ChainSystem system;
  build_chain_system(trajectory, segment, state, RobustLoss{}, system);
  // The attitude may be unobserved, as for a single antenna on a straight path. It then gets the variance of
  // an unknown angle.
  if (trajectory.motion == Motion::kSpatial) add_vague_angles(trajectory.motion, system.D[0]);
  out.ok = eliminate_states(system, system.D.size(), out.inverse) && !out.inverse.empty();
  out.U = std::move(system.U);
  return out;
}

}  // namespace octant
