// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/tile_sum.h"

#include <numeric>

#include "calib/adjust/node_buffer.h"
#include "calib/sums/over_ranks.h"
#include "models/support/parallel.h"

namespace octant::calib {
namespace {

/// Shares of the tiles: enough for the ranks and threads of one problem, few enough for a system each.
constexpr std::size_t kShares = 16;

}  // namespace

TileSum::TileSum(std::vector<Trajectory>& trajectories, const ParameterLayout& layout, const Workers& workers)
    : layout_(layout),
      workers_(workers),
      tiles_(make_tiles(trajectories, layout, workers.threads)),
      costs_(tiles_.size()),
      all_columns_(all_columns(layout.size())) {}

bool TileSum::is_mine(std::size_t share) const {
  if (workers_.ranks == nullptr) return true;
  return share * static_cast<std::size_t>(workers_.ranks->count()) / kShares ==
         static_cast<std::size_t>(workers_.ranks->index());
}

std::size_t TileSum::first_of(std::size_t share) const { return share * tiles_.size() / kShares; }

/// Calls work(tile, index, share, threads) for every tile of this rank; those of one share in order, on one
/// thread, then long ones one by one, on all threads.
template <class Work>
void TileSum::for_each_of_mine(Work&& work) {
  for_each_parallel(kShares, workers_.threads, [&](std::size_t share) {
    if (!is_mine(share)) return;
    for (std::size_t i = first_of(share); i < first_of(share + 1); ++i)
      if (!tiles_[i].is_long()) work(tiles_[i], i, share, 1);
  });
  for (std::size_t share = 0; share < kShares; ++share) {
    if (!is_mine(share)) continue;
    for (std::size_t i = first_of(share); i < first_of(share + 1); ++i)
      if (tiles_[i].is_long()) work(tiles_[i], i, share, workers_.threads);
  }
}

double TileSum::solve_states(const SharedState& state, const RobustLoss& loss) {
  std::ranges::fill(costs_, 0.0);
  for_each_of_mine([&](Tile& tile, std::size_t i, std::size_t, int threads) {
    costs_[i] = tile.solve_states(state, loss, threads);
  });
  sum_over(workers_.ranks, costs_);
  return std::accumulate(costs_.begin(), costs_.end(), 0.0);
}

void TileSum::reduce(const SharedState& state, const RobustLoss& loss, ReducedSystem& sum) {
  const auto n = static_cast<Eigen::Index>(layout_.size());
  shares_.resize(kShares);
  for (ReducedSystem& share : shares_) {
    share.H.setZero(n, n);
    share.gradient.setZero(n);
  }
  std::vector<double> off(tiles_.size(), 0.0);
  for_each_of_mine([&](Tile& tile, std::size_t i, std::size_t share, int threads) {
    off[i] = tile.reduce(state, loss, all_columns_, shares_[share], threads);
    tile.commit();
  });
  correct_costs(off);
  sum.H = shares_[0].H;
  sum.gradient = shares_[0].gradient;
  for (std::size_t share = 1; share < kShares; ++share) {
    sum.H += shares_[share].H;
    sum.gradient += shares_[share].gradient;
  }
  complete(sum);
  sum.cost = std::accumulate(costs_.begin(), costs_.end(), 0.0);
}

std::vector<SystemPart> TileSum::reduce_each(const SharedState& state, const RobustLoss& loss) {
  std::vector<SystemPart> parts;
  parts.reserve(tiles_.size());
  for (const Tile& tile : tiles_) parts.push_back(empty_part(tile.columns()));
  std::vector<double> off(tiles_.size(), 0.0);
  for_each_of_mine([&](Tile& tile, std::size_t i, std::size_t, int threads) {
    off[i] = tile.reduce(state, loss, tile.local_of(), parts[i].system, threads);
    tile.commit();
  });
  correct_costs(off);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].system.cost = costs_[i];
    complete(parts[i].system);
  }
  return parts;
}

void TileSum::reduce_onto(const SharedState& state, SystemParts& sum) {
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    SystemPart part = empty_part(tiles_[i].columns());
    costs_[i] += tiles_[i].reduce(state, {}, tiles_[i].local_of(), part.system);
    tiles_[i].commit();
    part.system.cost = costs_[i];
    part.system.H = part.system.H.selfadjointView<Eigen::Lower>();
    sum.add(part);
  }
}

void TileSum::complete(ReducedSystem& system) const {
  if (workers_.ranks != nullptr) {
    workers_.ranks->sum({system.H.data(), static_cast<std::size_t>(system.H.size())});
    workers_.ranks->sum({system.gradient.data(), static_cast<std::size_t>(system.gradient.size())});
  }
  system.H = system.H.selfadjointView<Eigen::Lower>();
}

void TileSum::correct_costs(std::vector<double>& off) {
  sum_over(workers_.ranks, off);
  for (std::size_t i = 0; i < costs_.size(); ++i) costs_[i] += off[i];
}

void TileSum::commit() {
  for_each_of_mine([](Tile& tile, std::size_t, std::size_t, int) { tile.commit(); });
}

void TileSum::share_states() {
  for_each_of_mine([](Tile& tile, std::size_t, std::size_t, int) { tile.rewind(); });
  if (workers_.ranks == nullptr) return;
  // The nodes of the ranks' shares, one behind the other, are those of all shares in their order.
  const auto for_each_node = [this](auto&& visit) {
    for (std::size_t share = 0; share < kShares; ++share)
      for (std::size_t i = first_of(share); i < first_of(share + 1); ++i) {
        Trajectory& t = tiles_[i].trajectory();
        tiles_[i].for_each_segment([&](std::size_t s) {
          for (std::size_t k = t.segments[s].first_node; k < t.segments[s].last_node; ++k)
            visit(share, t.nodes[k]);
        });
      }
  };
  std::vector<std::vector<double>> mine(1);
  BufferWriter writer(mine.front());
  for_each_node([&](std::size_t share, const Node& node) {
    if (is_mine(share)) writer.exchange(node);
  });
  const std::vector<double> all = in_order(workers_.ranks, std::move(mine));
  BufferReader reader(all);
  for_each_node([&](std::size_t, Node& node) { reader.exchange(node); });
}

}  // namespace octant::calib
