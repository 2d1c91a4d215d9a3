// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/pass_summer.h"

#include <memory>

#include "calib/adjust/reject.h"
#include "calib/adjust/tile_sum.h"

namespace octant::calib {

void PassSummer::add(std::size_t chunk, std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
                     const SharedState& state, double limit, RejectionPolicy policy, ReducedSystem& system) {
  Chunk& n = chunks_[chunk];
  std::size_t changed = 0;
  if (policy == RejectionPolicy::kFirst) changed = reject_outliers(trajectories, state, limit);
  auto tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
  n.counts.cost_before = n.cost = tiles->solve_states(state, {});
  if (policy == RejectionPolicy::kConverged) {
    tiles->commit();
    tiles->share_states();
    changed = reject_outliers(trajectories, state, limit);
    if (changed > 0) {
      tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
      n.cost = tiles->solve_states(state, {});
    }
  }
  tiles->reduce(state, {}, system);
  tiles->share_states();
  // The costs of chains are known better now (Tile::reduce).
  if (policy != RejectionPolicy::kConverged || changed == 0) n.counts.cost_before = system.cost;
  n.cost = system.cost;
  n.counts.changed = changed;
  for (const Trajectory& t : trajectories) n.counts.of_log.add(count_observations(t, state, 1, false));
  systems_.add(chunk, system, [this](std::size_t, const ReducedSystem& next) {
    sum_.cost += next.cost;
    sum_.H += next.H;
    sum_.gradient += next.gradient;
  });
}

std::vector<double> PassSummer::numbers() && {
  double cost = 0.0;
  PassCounts counts;
  for (const Chunk& n : chunks_) {
    cost += n.cost;
    counts.add(n.counts);
  }
  std::vector<double> all = {cost};
  const auto counted = counts.as_numbers();
  all.insert(all.end(), counted.begin(), counted.end());
  all.insert(all.end(), sum_.gradient.data(), sum_.gradient.data() + sum_.gradient.size());
  all.insert(all.end(), sum_.H.data(), sum_.H.data() + sum_.H.size());
  return all;
}

PassSum PassSummer::sum_of(const std::vector<double>& all, Eigen::Index n) {
  PassSum sum;
  const double* at = all.data();
  sum.system.cost = *at++;
  sum.counts = PassCounts::from_numbers(at);
  at += PassCounts::kSize;
  sum.system.gradient = Eigen::Map<const Eigen::VectorXd>(at, n);
  sum.system.H = Eigen::Map<const Eigen::MatrixXd>(at + n, n, n);
  return sum;
}

}  // namespace octant::calib
