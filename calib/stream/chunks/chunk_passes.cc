// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/chunk_passes.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <utility>

#include "calib/adjust/reject.h"
#include "calib/adjust/tile_sum.h"
#include "calib/problem/flips.h"
#include "calib/problem/gates.h"
#include "calib/stream/long_log.h"
#include "calib/stream/side_by_side.h"
#include "calib/sums/over_ranks.h"
#include "calib/sums/reduced_system.h"
#include "models/trajectory/make_trajectory.h"
#include "models/trajectory/solve_states.h"
#include "models/trajectory/stretches.h"

namespace octant::calib {
namespace {

/// An arrival in work: its row, its observation, its place in a tile and what comes and goes.
constexpr std::size_t kBytesInWork = 240;
/// More than these at once are no faster.
constexpr std::size_t kMostInChunk = std::size_t{1} << 18;

constexpr std::size_t kBesideChunks = std::size_t{200} << 20;

/// visit(number, trajectory, arrival), numbered within the vehicle's run.
template <class Visit>
void for_each_arrival(const ChunkWork& w, Visit&& visit) {
  for (const Trajectory& t : w.trajectories) {
    std::size_t number = w.chunk->arrivals_before[t.vehicle.index()];
    for (const ArrivalObservation& a : t.arrivals) visit(number++, t, a);
  }
}

/// Adds the results of the chunks of a log in their order, for any order of completion, so that no sum
/// depends on the number of threads.
class PassSummer {
 public:
  /// @param first  first chunk of this rank
  PassSummer(std::size_t first, const ParameterLayout& layout) : in_order_(first), layout_(layout) {
    if (is_dense(layout_)) sum_.system.whole_part(layout_.size());
  }

  /// Solves for the trajectories of a chunk with plain squares, marks them as asked, and reduces them.
  /// @param limit  sigmas beyond which an arrival is rejected
  void add(std::size_t chunk, ChunkWork& w, const SharedState& state, double limit, RejectionPolicy policy) {
    PassCounts& counts = w.sum.counts = {};
    if (policy == RejectionPolicy::kFirst) counts.changed = reject_outliers(w.trajectories, state, limit);
    auto tiles = std::make_unique<TileSum>(w.trajectories, layout_, Workers{});
    counts.cost_before = tiles->solve_states(state, {});
    if (policy == RejectionPolicy::kConverged) {
      tiles->commit();
      tiles->share_states();
      counts.changed = reject_outliers(w.trajectories, state, limit);
      if (counts.changed > 0) {
        tiles = std::make_unique<TileSum>(w.trajectories, layout_, Workers{});
        static_cast<void>(tiles->solve_states(state, {}));
      }
    }
    reduce(*tiles, state, w.sum.system);
    tiles->share_states();
    // The costs of chains are known better now (Tile::reduce).
    if (policy != RejectionPolicy::kConverged || counts.changed == 0)
      counts.cost_before = w.sum.system.cost();
    for (const Trajectory& t : w.trajectories) {
      counts.of_log.add(count_observations(t, state, 1, false));
      counts.poses.add(squares_of_poses(t, state));
    }
    in_order_.add(chunk, w.sum, [this](std::size_t, const PassSum& next) { sum_.add(next); });
  }
  /// The sum over the chunks of all ranks.
  [[nodiscard]] PassSum sum(const Ranks* ranks) && {
    sum_over(ranks, sum_.counts);
    if (is_dense(layout_)) {
      sum_over(ranks, sum_.system.whole_part(layout_.size()));
    } else {
      sum_over(ranks, sum_.system);
    }
    return std::move(sum_);
  }

 private:
  void reduce(TileSum& tiles, const SharedState& state, SystemParts& sum) const {
    if (is_dense(layout_)) {
      tiles.reduce(state, {}, sum.whole_part(layout_.size()));  // the worker's, whose memory stays
      return;
    }
    sum = {};
    tiles.reduce_onto(state, sum);
  }

  OrderedParts<PassSum> in_order_;
  const ParameterLayout& layout_;
  PassSum sum_;
};

}  // namespace

StreamPlan stream_plan(std::size_t memory_bytes, int threads) {
  // Part of the memory is reserved for the data that are kept between passes, and for the sampled epochs.
  memory_bytes -= std::min(memory_bytes / 2, kBesideChunks);
  StreamPlan plan;
  plan.chunk_arrivals = std::clamp<std::size_t>(memory_bytes / 8 / kBytesInWork, 1, kMostInChunk);
  plan.piece_bytes = plan.chunk_arrivals * kBytesInWork;
  plan.workers =
      static_cast<int>(std::clamp<std::size_t>(memory_bytes / 2 / (plan.chunk_arrivals * kBytesInWork), 1,
                                               static_cast<std::size_t>(std::max(threads, 1))));
  return plan;
}

ChunkPasses::ChunkPasses(const ReadingTask& task, const ChunkIndex& index)
    : task_(task), index_(index), model_(trajectory_model(task.frame.site)), kept_(index.chunks().size()) {
  std::tie(first_, last_) = parts_of(task.options.ranks, index.chunks().size());
  for (std::size_t run = 0; run < task.frame.runs.size(); ++run)
    bearings_.emplace_back(task.source.log(run).bearings, index.kinds(run));
  for (int i = 0; i < task.workers; ++i) workers_.push_back(std::make_unique<ChunkWork>());
}

/// work(chunk, ChunkWork&), with the chunk loaded.
template <class Do>
Result<void> ChunkPasses::for_each_chunk_of_mine(Do&& work) {
  return for_each_side_by_side(first_, last_, workers_.size(), task_.monitor,
                               [&](std::size_t k, std::size_t worker) -> Result<void> {
                                 if (auto ok = load(k, *workers_[worker]); !ok) return ok;
                                 work(k, *workers_[worker]);
                                 return {};
                               });
}

Result<void> ChunkPasses::load(std::size_t chunk, ChunkWork& w) const {
  const Chunk& c = index_.chunks()[chunk];
  const MeasurementLog& run = task_.source.log(c.run);
  const std::vector<StateKind>& kinds = index_.kinds(c.run);
  if (w.chunk == nullptr || w.chunk->run != c.run) {
    begin_run(run, w.log);
    w.log.poses = run.poses;
    if (std::ranges::find(kinds, StateKind::kChainedStops) != kinds.end()) w.log.odometry = run.odometry;
  }
  w.chunk = &c;
  if (auto ok = index_.read(task_.source, c.run, c.first_block, c.last_block, w.log.arrivals); !ok) return ok;
  const std::vector<std::size_t> bearings = bearings_[c.run].of_states_in(w.log.arrivals);
  w.log.bearings.clear();
  for (const std::size_t b : bearings) w.log.bearings.push_back(run.bearings[b]);
  w.trajectories.clear();
  for (std::size_t v = 0; v < c.arrivals.size(); ++v) {
    if (c.arrivals[v] == 0) continue;
    Trajectory& t = w.trajectories.emplace_back(make_trajectory(w.log, c.run, VehicleId(v), model_));
    for (BearingObservation& b : t.bearings) b.bearing = bearings[b.bearing];
    widen_poses(task_.frame, t);
    const bool has_all = t.arrivals.size() + t.stateless_arrivals.size() == c.arrivals[v] &&
                         (kinds[v] != StateKind::kStops || t.nodes.size() == c.states[v]);
    if (!has_all) return fail(changed_while_read(w.log));
  }
  if (!is_as_before(chunk, w)) return fail(changed_while_read(w.log));
  return {};
}

/// Returns true if an earlier pass processed a chunk with the same states and observations.
bool ChunkPasses::is_as_before(std::size_t chunk, const ChunkWork& w) const {
  const std::vector<KeptTrajectory>& kept = kept_[chunk].trajectories;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (!kept[i].fits(w.trajectories[i])) return false;
  return true;
}

void ChunkPasses::restore(const KeptChunk& kept, const Estimate& estimate, ChunkWork& w) const {
  take_noise(task_.frame, estimate, w.trajectories);
  for (std::size_t i = 0; i < w.trajectories.size(); ++i) kept.trajectories[i].restore(w.trajectories[i]);
}

void ChunkPasses::keep(const ChunkWork& w, KeptChunk& kept) {
  kept.trajectories.resize(w.trajectories.size());
  for (std::size_t i = 0; i < w.trajectories.size(); ++i) kept.trajectories[i].keep(w.trajectories[i]);
}

Result<LogReadings::Placed> ChunkPasses::place(const Estimate& estimate, double suspect_sigmas, bool reject) {
  const SharedState state = estimate.state();
  SpreadArrivals spread(task_, state, kept_.size());
  PassSummer summer(first_, estimate.layout);
  auto done = for_each_chunk_of_mine([&](std::size_t k, ChunkWork& w) {
    for_each_arrival(w, [&](std::size_t number, const Trajectory& t, const ArrivalObservation& a) {
      spread.add_range(k, number, t, a);
    });
    apply_gates(task_.frame.site, w.trajectories, 1);
    place_all(task_.frame, estimate.layout, state, estimate.beacon_usable, suspect_sigmas, {},
              w.trajectories);
    kept_[k].start_heading_rad.clear();
    for (const Trajectory& t : w.trajectories) {
      for (const Node& n : t.nodes)
        kept_[k].start_heading_rad.push_back(n.placed ? static_cast<float>(n.T_map_vehicle.heading_rad())
                                                      : NAN);
    }
    for_each_arrival(w, [&](std::size_t number, const Trajectory& t, const ArrivalObservation& a) {
      spread.add_residual(k, number, t, a);
    });
    if (reject) summer.add(k, w, state, task_.options.rejection_sigmas, RejectionPolicy::kFirst);
    keep(w, kept_[k]);
  });
  if (!done) return fail(done.error());
  Placed placed = std::move(spread).placed(task_.options.ranks);
  std::vector<double> states = {0.0};
  for (const KeptChunk& kept : kept_) states[0] += static_cast<double>(kept.start_heading_rad.size());
  sum_over(task_.options.ranks, states);
  placed.states = static_cast<std::size_t>(states[0]);
  if (!reject) return placed;
  placed.sum = std::move(summer).sum(task_.options.ranks);
  return placed;
}

Result<PassSum> ChunkPasses::pass(const Estimate& estimate, RejectionPolicy policy) {
  const SharedState state = estimate.state();
  PassSummer summer(first_, estimate.layout);
  auto done = for_each_chunk_of_mine([&](std::size_t k, ChunkWork& w) {
    restore(kept_[k], estimate, w);
    summer.add(k, w, state, task_.options.rejection_sigmas, policy);
    keep(w, kept_[k]);
  });
  if (!done) return fail(done.error());
  return std::move(summer).sum(task_.options.ranks);
}

Result<void> ChunkPasses::gather(const Estimate& estimate, FindingsGatherer& gatherer) {
  std::vector<std::vector<double>> buffers(kept_.size());
  auto done = for_each_chunk_of_mine([&](std::size_t k, ChunkWork& w) {
    restore(kept_[k], estimate, w);
    const float* start_heading_rad = kept_[k].start_heading_rad.data();
    for (const Trajectory& t : w.trajectories) {
      gather_trajectory(w, t, start_heading_rad, gatherer, buffers[k]);
      start_heading_rad += t.nodes.size();
    }
  });
  if (!done) return done;
  gatherer.read(in_order(task_.options.ranks, std::move(buffers)));
  return {};
}

/// @param start_heading_rad  of each of its states
void ChunkPasses::gather_trajectory(const ChunkWork& w, const Trajectory& t, const float* start_heading_rad,
                                    const FindingsGatherer& gatherer, std::vector<double>& buffer) const {
  const std::size_t before = w.chunk->states_before[t.vehicle.index()], stride = gatherer.stride();
  const bool cut = stride > 1 && std::ranges::any_of(t.segments, is_long_chain);
  const std::vector<Segment> stretches = cut ? with_chains_cut(t) : std::vector<Segment>();
  const std::vector<Segment>& all = cut ? stretches : t.segments;
  std::vector<Segment> some;
  for (std::size_t k = (stride - before % stride) % stride; k < all.size(); k += stride)
    some.push_back(all[k]);
  TrajectoryFindings part{t, w.log, pick_segments(t, some)};
  // Information from the neighbours of a segment about its ends is not part of the sample.
  for (const Segment& s : part.sampled.segments)
    if (cut && part.sampled.nodes[s.first_node].placed)
      octant::solve_states(part.sampled, s, gatherer.state(), {});
  for (std::size_t k = 0; k < t.nodes.size(); ++k)
    if (!t.moving && t.motion == Motion::kPlanar &&
        is_flipped(t.nodes[k], static_cast<double>(start_heading_rad[k])))
      part.flipped.push_back(t.nodes[k].epoch);
  gatherer.write(part, buffer);
}

}  // namespace octant::calib
