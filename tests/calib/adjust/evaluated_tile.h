// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/adjust/tile.h"

namespace octant::test {

/// Solves for a tile's states and reduces it in its own columns.
/// @param system  null: the states are solved alone
/// @return the cost
inline double evaluated(calib::Tile& tile, const SharedState& state, const RobustLoss& loss,
                        calib::ReducedSystem* system = nullptr) {
  const double cost = tile.solve_states(state, loss);
  if (system == nullptr) return cost;
  const auto n = static_cast<Eigen::Index>(tile.columns().size());
  system->H.setZero(n, n);
  system->gradient.setZero(n);
  system->cost = cost + tile.reduce(state, loss, tile.local_of(), *system);
  system->H = system->H.selfadjointView<Eigen::Lower>();
  return system->cost;
}

}  // namespace octant::test
