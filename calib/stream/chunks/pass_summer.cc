// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/pass_summer.h"

#include <memory>
#include <utility>

#include "calib/adjust/reject.h"
#include "calib/adjust/tile_sum.h"
#include "calib/stream/over_ranks.h"

namespace octant::calib {

void PassSummer::add(std::size_t chunk, std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
                     const SharedState& state, double limit, RejectionPolicy policy, PassSum& of_chunk) {
  ReducedSystem& system = of_chunk.system;
  PassCounts& counts = of_chunk.counts = {};
  if (policy == RejectionPolicy::kFirst) counts.changed = reject_outliers(trajectories, state, limit);
  auto tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
  counts.cost_before = tiles->solve_states(state, {});
  if (policy == RejectionPolicy::kConverged) {
    tiles->commit();
    tiles->share_states();
    counts.changed = reject_outliers(trajectories, state, limit);
    if (counts.changed > 0) {
      tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
      static_cast<void>(tiles->solve_states(state, {}));
    }
  }
  tiles->reduce(state, {}, system);
  tiles->share_states();
  // The costs of chains are known better now (Tile::reduce).
  if (policy != RejectionPolicy::kConverged || counts.changed == 0) counts.cost_before = system.cost;
  for (const Trajectory& t : trajectories) {
    counts.of_log.add(count_observations(t, state, 1, false));
    counts.poses.add(squares_of_poses(t, state));
  }
  in_order_.add(chunk, of_chunk, [this](std::size_t, const PassSum& next) { sum_.add(next); });
}

PassSum PassSummer::sum(const Ranks* ranks) && {
  sum_over(ranks, sum_);
  return std::move(sum_);
}

}  // namespace octant::calib
