// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/stops/pass_summer.h"

#include <memory>

#include "calib/adjust/reject.h"
#include "calib/adjust/tile_sum.h"

namespace octant::calib {

void PassSummer::take(std::size_t chunk, std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
                      const SharedState& state, double limit, MarkPolicy marks, ReducedSystem& system) {
  Numbers& n = numbers_[chunk];
  std::size_t changed = 0;
  if (marks == MarkPolicy::kFirst) changed = mark_rejected(trajectories, state, limit);
  auto tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
  n.cost_before = n.cost = tiles->settle(state, {});
  if (marks == MarkPolicy::kSettled) {
    tiles->commit();
    tiles->share_states();
    changed = mark_rejected(trajectories, state, limit);
    if (changed > 0) {
      tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
      n.cost = tiles->settle(state, {});
    }
  }
  tiles->reduce(state, {}, system);
  tiles->share_states();
  n.changed = static_cast<double>(changed);
  for (const Trajectory& t : trajectories) n.counts.add(count_observations(t, state, 1, false));
  systems_.add(chunk, system, [this](std::size_t, const ReducedSystem& next) {
    sum_.cost += next.cost;
    sum_.H += next.H;
    sum_.gradient += next.gradient;
  });
}

std::vector<double> PassSummer::numbers() && {
  Numbers sum;
  for (const Numbers& n : numbers_) {
    sum.cost += n.cost;
    sum.cost_before += n.cost_before;
    sum.changed += n.changed;
    sum.counts.add(n.counts);
  }
  std::vector<double> all = {sum.cost,
                             sum.cost_before,
                             sum.changed,
                             static_cast<double>(sum.counts.used),
                             static_cast<double>(sum.counts.rejected),
                             sum.counts.observations,
                             static_cast<double>(sum.counts.states)};
  all.insert(all.end(), sum_.gradient.data(), sum_.gradient.data() + sum_.gradient.size());
  all.insert(all.end(), sum_.H.data(), sum_.H.data() + sum_.H.size());
  return all;
}

PassSum PassSummer::sum_of(const std::vector<double>& all, Eigen::Index n) {
  PassSum sum;
  sum.system.cost = all[0];
  sum.cost_before = all[1];
  sum.changed = static_cast<std::size_t>(all[2]);
  sum.counts.used = static_cast<std::size_t>(all[3]);
  sum.counts.rejected = static_cast<std::size_t>(all[4]);
  sum.counts.observations = all[5];
  sum.counts.states = static_cast<std::size_t>(all[6]);
  sum.system.gradient = Eigen::Map<const Eigen::VectorXd>(all.data() + 7, n);
  sum.system.H = Eigen::Map<const Eigen::MatrixXd>(all.data() + 7 + n, n, n);
  return sum;
}

}  // namespace octant::calib
