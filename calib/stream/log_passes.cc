// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/log_passes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "calib/problem/gates.h"
#include "calib/problem/ranges.h"
#include "calib/problem/thin.h"
#include "calib/stream/long_log.h"
#include "calib/stream/side_by_side.h"

namespace octant::calib {
namespace {

/// An arrival in work: its row, its observation, its place in a tile and what comes and goes.
constexpr std::size_t kBytesInWork = 240;
/// More than these at once are no faster.
constexpr std::size_t kMostInChunk = std::size_t{1} << 18;

constexpr std::size_t kBesideChunks = std::size_t{200} << 20;

}  // namespace

StreamPlan stream_plan(std::size_t memory_bytes, int threads) {
  // Something is left for what remains of the readings, and for the epochs that are looked at one by one.
  memory_bytes -= std::min(memory_bytes / 2, kBesideChunks);
  StreamPlan plan;
  plan.chunk_arrivals = std::clamp<std::size_t>(memory_bytes / 8 / kBytesInWork, 1, kMostInChunk);
  plan.piece_bytes = plan.chunk_arrivals * kBytesInWork;
  plan.workers =
      static_cast<int>(std::clamp<std::size_t>(memory_bytes / 2 / (plan.chunk_arrivals * kBytesInWork), 1,
                                               static_cast<std::size_t>(std::max(threads, 1))));
  return plan;
}

LogPasses::LogPasses(const Problem& frame, const ArrivalSource& source, const LogIndex& index,
                     const SolveOptions& options, int workers, Course& course)
    : frame_(frame),
      source_(source),
      index_(index),
      options_(options),
      course_(course),
      model_(trajectory_model(frame.site)),
      stops_(index.chunks().size()) {
  const std::size_t chunks = index.chunks().size();
  const auto count = static_cast<std::size_t>(options.ranks != nullptr ? options.ranks->count() : 1);
  const auto rank = static_cast<std::size_t>(options.ranks != nullptr ? options.ranks->index() : 0);
  first_ = rank * chunks / count;
  last_ = (rank + 1) * chunks / count;
  for (int i = 0; i < workers; ++i) workers_.push_back(std::make_unique<ChunkWork>());
}

/// work(chunk, ChunkWork&), with the chunk loaded.
template <class Do>
Result<void> LogPasses::for_each_chunk_of_mine(Do&& work) {
  return for_each_side_by_side(first_, last_, workers_.size(), course_,
                               [&](std::size_t k, std::size_t worker) -> Result<void> {
                                 if (auto ok = load(k, *workers_[worker]); !ok) return ok;
                                 work(k, *workers_[worker]);
                                 return {};
                               });
}

Result<void> LogPasses::load(std::size_t chunk, ChunkWork& w) const {
  const LogChunk& c = index_.chunks()[chunk];
  if (w.chunk == nullptr || w.chunk->run != c.run) {
    begin_run(source_.log(c.run), w.log);
  }
  w.chunk = &c;
  if (auto ok = index_.read(source_, c.run, c.first_block, c.last_block, w.log.arrivals); !ok) return ok;
  w.trajectories.clear();
  for (std::size_t v = 0; v < c.arrivals.size(); ++v) {
    if (c.arrivals[v] == 0) continue;
    w.trajectories.push_back(make_trajectory(w.log, c.run, VehicleId(v), model_));
    if (w.trajectories.back().arrivals.size() == c.arrivals[v] &&
        w.trajectories.back().nodes.size() == c.epochs[v])
      continue;
    return fail(changed_while_read(w.log));
  }
  return {};
}

void LogPasses::restore(const ChunkStops& stops, double sigma_s, ChunkWork& w) const {
  std::size_t node = 0, arrival = 0;
  for (Trajectory& t : w.trajectories) {
    for (Node& n : t.nodes) put_state(stops.pose[node++], n);
    for (ArrivalObservation& a : t.arrivals) {
      a.rejection = stops.marks[arrival++];
      a.sigma_s = sigma_s;
    }
  }
}

void LogPasses::keep(const ChunkWork& w, ChunkStops& stops) const {
  stops.pose.clear();
  stops.marks.clear();
  for (const Trajectory& t : w.trajectories) {
    for (const Node& n : t.nodes) stops.pose.push_back(kept_state(n));
    for (const ArrivalObservation& a : t.arrivals) stops.marks.push_back(a.rejection);
  }
}

/// Over the ranks.
void LogPasses::add_up(std::vector<double>& numbers) const {
  if (options_.ranks != nullptr) options_.ranks->sum(numbers);
}

/// Lists of all chunks of all ranks, one behind the other in the order of the chunks.
std::vector<double> LogPasses::in_order(std::vector<std::vector<double>> of_chunks) const {
  std::vector<double> mine;
  for (std::vector<double>& list : of_chunks) {
    mine.insert(mine.end(), list.begin(), list.end());
    list = {};
  }
  if (options_.ranks == nullptr) return mine;
  std::vector<double> sizes(static_cast<std::size_t>(options_.ranks->count()), 0.0);
  const auto rank = static_cast<std::size_t>(options_.ranks->index());
  sizes[rank] = static_cast<double>(mine.size());
  add_up(sizes);
  const auto sum_until = [&](std::size_t i) {
    return static_cast<std::size_t>(
        std::accumulate(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(i), 0.0));
  };
  std::vector<double> all(sum_until(sizes.size()), 0.0);
  std::copy(mine.begin(), mine.end(), all.begin() + static_cast<std::ptrdiff_t>(sum_until(rank)));
  add_up(all);
  return all;
}

Result<LogReadings::Placed> LogPasses::place(const Estimate& estimate, double suspect_sigmas, bool mark) {
  const SharedState state = estimate.state();
  const SpreadArrivals spread(index_.arrivals(), state, prior_state(frame_.site));
  std::vector<std::vector<double>> residuals(stops_.size()), ranges(stops_.size());
  PassSummer summer(first_, stops_.size(), estimate.layout.size());
  const auto done = for_each_chunk_of_mine([&](std::size_t k, ChunkWork& w) {
    apply_gates(frame_.site, w.trajectories, 1);
    place_all_stops(frame_, estimate.layout, state, estimate.beacon_usable, suspect_sigmas, {},
                    w.trajectories);
    stops_[k].start_heading_rad.clear();
    for (const Trajectory& t : w.trajectories) {
      for (const Node& n : t.nodes)
        stops_[k].start_heading_rad.push_back(n.placed ? static_cast<float>(n.T_map_vehicle.heading_rad())
                                                       : NAN);
      const std::size_t before = w.chunk->arrivals_before[t.vehicle.index()];
      for (std::size_t i = 0; i < t.arrivals.size(); ++i)
        spread.look_at(before + i, t, t.arrivals[i], residuals[k], ranges[k]);
    }
    if (mark)
      summer.take(k, w.trajectories, estimate.layout, state, options_.rejection_sigmas, MarkPolicy::kFirst,
                  w.system);
    keep(w, stops_[k]);
  });
  if (!done) return fail(done.error());
  Placed placed;
  placed.residuals = in_order(std::move(residuals));
  placed.ranges_m = in_order(std::move(ranges));
  if (!mark) return placed;
  std::vector<double> numbers = std::move(summer).numbers();
  add_up(numbers);
  placed.sum = PassSummer::sum_of(numbers, estimate.layout.size());
  return placed;
}

Result<PassSum> LogPasses::pass(const Estimate& estimate, MarkPolicy marks) {
  const SharedState state = estimate.state();
  const double sigma_s = frame_.site.noise.tof_sigma_s * estimate.noise_factor;
  PassSummer summer(first_, stops_.size(), estimate.layout.size());
  const auto done = for_each_chunk_of_mine([&](std::size_t k, ChunkWork& w) {
    restore(stops_[k], sigma_s, w);
    summer.take(k, w.trajectories, estimate.layout, state, options_.rejection_sigmas, marks, w.system);
    keep(w, stops_[k]);
  });
  if (!done) return fail(done.error());
  std::vector<double> numbers = std::move(summer).numbers();
  add_up(numbers);
  return PassSummer::sum_of(numbers, estimate.layout.size());
}

Result<LogFindings> LogPasses::findings(const Estimate& estimate) {
  FindingsGatherer gatherer(frame_, source_, index_, model_, estimate);
  std::vector<std::vector<double>> tapes(stops_.size());
  const double sigma_s = frame_.site.noise.tof_sigma_s * estimate.noise_factor;
  const auto done = for_each_chunk_of_mine([&](std::size_t k, ChunkWork& w) {
    restore(stops_[k], sigma_s, w);
    gatherer.write(w, stops_[k], k, tapes[k]);
  });
  if (!done) return fail(done.error());
  gatherer.read(in_order(std::move(tapes)));
  return std::move(gatherer).findings(estimate);
}

}  // namespace octant::calib
