// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/tile.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "models/support/parallel.h"
#include "models/trajectory/solve_states.h"

namespace octant::calib {
namespace {

constexpr std::size_t kNodesPerTile = 512;
constexpr std::size_t kNodesOfLongChain = 1024;
/// A step of a chain's states that gains less than this fraction of the cost is the last one: the next would
/// gain a hundredth of that at most, and the reduction includes its first order. The weights of a robust loss
/// bend the cost more than that order.
constexpr double kChainAtRest = 1e-3, kRobustChainAtRest = 1e-5;
/// With plain squares a step of a few centimetres is the last too: this share of the cost at most is left to
/// the reduction.
constexpr double kLeftToReduction = 0.01;
/// If the shared system is sparse, a tile ends beyond this number of beacons, because its own system is dense
/// in its columns.
constexpr std::size_t kBeaconsPerSparseTile = 24;

}  // namespace

Tile::Tile(Trajectory* trajectory, std::vector<std::size_t> stops, const StopArrivals* arrivals,
           std::vector<std::size_t> general, const ParameterLayout* layout)
    : trajectory_(trajectory),
      layout_(layout),
      stop_segments_(std::move(stops)),
      general_(std::move(general)) {
  if (!stop_segments_.empty())
    stops_ = std::make_unique<StopBlock>(trajectory_, stop_segments_, *arrivals, layout_);
  if (!general_.empty()) chains_ = std::make_unique<ChainReduction>(*trajectory_, *layout_, general_);
  for (const std::size_t s : general_) {
    const Segment& segment = trajectory_->segments[s];
    is_long_ = is_long_ || segment.last_node - segment.first_node > kNodesOfLongChain;
  }
  find_columns();
  commit();
}

void Tile::find_columns() {
  const ParameterLayout& layout = *layout_;
  const Trajectory& t = *trajectory_;
  std::vector<char> touched(static_cast<std::size_t>(layout.size()), 0);
  const auto touch = [&](const PathColumns& path) {
    for (const PathColumns::Column& of : path) touched[static_cast<std::size_t>(of.column)] = 1;
  };
  if (chains_)
    for (const PathColumns& path : chains_->paths()) touch(path);
  if (stops_) {
    std::vector<char> beacon(layout.beacon.size(), 0), receiver(layout.receiver.size(), 0);
    stops_->collect_heard(beacon, receiver);
    for (std::size_t b = 0; b < beacon.size(); ++b)
      for (std::size_t r = 0; beacon[b] != 0 && r < receiver.size(); ++r)
        if (receiver[r] != 0) touch(path_columns(layout, BeaconId(b), ReceiverId(r), t.run));
  }
  for (const std::size_t s : general_) {
    const Segment& segment = t.segments[s];
    for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i)
      if (const BeaconId reflector = t.bearings[i].reflector; reflector.valid())
        touch(path_columns(layout, reflector, ReceiverId(), t.run));
  }

  local_of_.assign(touched.size(), -1);
  for (const ParameterBlock& block : layout.blocks) {
    bool any = false;
    for (int c = block.first; c < block.first + block.size; ++c)
      any = any || touched[static_cast<std::size_t>(c)] != 0;
    if (!any) continue;
    for (int c = block.first; c < block.first + block.size; ++c) {
      local_of_[static_cast<std::size_t>(c)] = static_cast<int>(columns_.size());
      columns_.push_back(c);
    }
  }
}

void Tile::commit() {
  if (stops_) stops_->commit();
  if (!has_moved_) return;
  has_moved_ = false;
  committed_.clear();
  for (const std::size_t s : general_) {
    const Segment& segment = trajectory_->segments[s];
    const auto begin = trajectory_->nodes.begin();
    committed_.insert(committed_.end(), begin + static_cast<std::ptrdiff_t>(segment.first_node),
                      begin + static_cast<std::ptrdiff_t>(segment.last_node));
  }
}

void Tile::rewind() {
  if (stops_) stops_->rewind();
  rewind_general();
}

void Tile::rewind_general() {
  if (!has_moved_) return;
  has_moved_ = false;
  auto from = committed_.begin();
  for (const std::size_t s : general_) {
    const Segment& segment = trajectory_->segments[s];
    const auto count = static_cast<std::ptrdiff_t>(segment.last_node - segment.first_node);
    std::copy(from, from + count,
              trajectory_->nodes.begin() + static_cast<std::ptrdiff_t>(segment.first_node));
    from += count;
  }
}

double Tile::solve_states(const SharedState& state, const RobustLoss& loss, int threads) {
  rewind_general();
  has_moved_ = true;
  double cost = stops_ ? stops_->solve_states(state, loss) : 0.0;
  solved_costs_.assign(general_.size(), 0.0);
  const StateSolveOptions single{.threads = threads},
      chain{.tolerance = is_plain(loss) ? kChainAtRest : kRobustChainAtRest,
            .left_behind = kLeftToReduction,
            .threads = threads};
  for (std::size_t i = 0; i < general_.size(); ++i) {
    const Segment& segment = trajectory_->segments[general_[i]];
    if (!trajectory_->nodes[segment.first_node].placed)
      continue;  // a segment that no start could place says nothing
    const bool is_chain = segment.last_node - segment.first_node > 1;
    solved_costs_[i] =
        octant::solve_states(*trajectory_, segment, state, loss, is_chain ? chain : single).cost;
    cost += solved_costs_[i];
  }
  return cost;
}

double Tile::reduce(const SharedState& state, const RobustLoss& loss, const std::vector<int>& place,
                    ReducedSystem& system, int threads) {
  if (stops_) stops_->reduce(state, loss, place, system);
  double off = 0.0;
  for (std::size_t i = 0; i < general_.size(); ++i) {
    const Segment& segment = trajectory_->segments[general_[i]];
    if (!trajectory_->nodes[segment.first_node].placed) continue;
    const double cost = chains_->reduce(segment, state, loss, place, threads, system);
    off += cost - std::exchange(solved_costs_[i], cost);
  }
  return off;
}

namespace {

/// Sort key of segments. Stops with the same beacons are in one tile, so that their common part is summed
/// first, and a tile has few beacons at a site with very many. Among these, stops with the same paths are
/// neighbours and share slots of the vector kernel.
struct SegmentKey {
  std::uint32_t segment = 0, nodes = 0;
  bool stop = false;                                                 ///< for the vector kernel
  std::uint32_t lowest = std::numeric_limits<std::uint32_t>::max();  ///< beacon
  std::uint64_t beacons = 0, paths = 0;  ///< a bit each, several sharing one where there are more than 64

  friend bool operator<(const SegmentKey& a, const SegmentKey& b) {
    return std::tie(a.lowest, a.beacons, a.paths, a.segment) <
           std::tie(b.lowest, b.beacons, b.paths, b.segment);
  }
};

/// By their lowest beacons first, each beacon's for itself, so that threads may share the work.
std::vector<SegmentKey> sorted(const std::vector<SegmentKey>& keys, std::size_t beacons, int threads) {
  const auto bucket_of = [beacons](const SegmentKey& key) {
    return std::min<std::size_t>(key.lowest, beacons);
  };
  std::vector<std::size_t> end(beacons + 2, 0);
  for (const SegmentKey& key : keys) ++end[bucket_of(key) + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<SegmentKey> out(keys.size());
  for (const SegmentKey& key : keys) out[end[bucket_of(key)]++] = key;  // now where the bucket ends
  for_each_parallel(beacons + 1, threads, [&](std::size_t b) {
    const auto at = [&](std::size_t i) { return out.begin() + static_cast<std::ptrdiff_t>(i); };
    std::sort(at(b == 0 ? 0 : end[b - 1]), at(end[b]));
  });
  return out;
}

/// Segments of a trajectory in the order of the tiles, and the data of the arrivals of stops.
std::vector<SegmentKey> tile_order(const Trajectory& t, const ParameterLayout& layout, int threads,
                                   StopArrivals* arrivals) {
  constexpr std::size_t kSegmentsAtOnce = 4096;
  std::vector<SegmentKey> keys(t.segments.size());
  const bool known = StopBlock::knows(t, layout);
  const auto receivers = static_cast<std::uint32_t>(layout.receiver.size());
  for_each_in_chunks(keys.size(), kSegmentsAtOnce, threads, [&](std::size_t s) {
    SegmentKey& key = keys[s];
    key.segment = static_cast<std::uint32_t>(s);
    key.nodes = static_cast<std::uint32_t>(t.segments[s].last_node - t.segments[s].first_node);
    key.stop = known && StopBlock::takes(t, t.segments[s]);
    for (std::size_t i = t.segments[s].first_arrival;
         i < t.segments[s].last_arrival && (key.stop || !t.moving); ++i) {
      const auto beacon = static_cast<std::uint32_t>(t.arrivals[i].beacon.value);
      if (key.stop) arrivals->add(i, t.arrivals[i]);
      key.lowest = std::min(key.lowest, beacon);
      key.beacons |= std::uint64_t{1} << (beacon % 64U);
      if (t.arrivals[i].rejection == Rejection::kUsed)
        key.paths |= std::uint64_t{1}
                     << ((beacon * receivers + static_cast<std::uint32_t>(t.arrivals[i].receiver.value)) %
                         64U);
    }
  });
  return t.moving ? keys : sorted(keys, layout.beacon.size(), threads);
}

}  // namespace

std::vector<Tile> make_tiles(std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
                             int threads) {
  struct TileContents {
    Trajectory* trajectory;
    const StopArrivals* arrivals;
    std::vector<std::size_t> stops{}, general{};
  };
  std::vector<std::unique_ptr<StopArrivals>> arrivals;
  std::vector<TileContents> parts;
  std::vector<std::size_t> heard_in(layout.beacon.size(),
                                    0);  // the last part, counted from one, that heard each beacon
  for (Trajectory& t : trajectories) {
    std::size_t nodes = 0, beacons = 0;
    StopArrivals* of_trajectory = nullptr;
    if (!t.arrivals.empty()) of_trajectory = arrivals.emplace_back(std::make_unique<StopArrivals>(t)).get();
    TileContents part{&t, of_trajectory};
    const auto close = [&] {
      if (nodes > 0) parts.push_back(std::exchange(part, {&t, of_trajectory}));
      nodes = beacons = 0;
    };
    const auto new_beacons = [&](const Segment& s) {
      std::size_t count = 0;
      for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
        if (std::size_t& last = heard_in[t.arrivals[i].beacon.index()]; last != parts.size() + 1) {
          last = parts.size() + 1;
          ++count;
        }
      return count;
    };
    for (const SegmentKey& key : tile_order(t, layout, threads, of_trajectory)) {
      if (!is_dense(layout)) beacons += new_beacons(t.segments[key.segment]);
      (key.stop ? part.stops : part.general).push_back(key.segment);
      nodes += key.nodes;
      if (nodes >= kNodesPerTile || beacons > kBeaconsPerSparseTile) close();
    }
    close();
  }
  std::vector<std::optional<Tile>> made(parts.size());
  for_each_parallel(parts.size(), threads, [&](std::size_t i) {
    made[i].emplace(parts[i].trajectory, std::move(parts[i].stops), parts[i].arrivals,
                    std::move(parts[i].general), &layout);
  });
  std::vector<Tile> tiles;
  tiles.reserve(made.size());
  for (auto& tile : made) tiles.push_back(std::move(*tile));
  return tiles;
}

}  // namespace octant::calib
