// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/chunk_index.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "calib/problem/problem.h"

namespace octant::calib {

std::size_t Chunk::all_arrivals() const {
  return std::accumulate(arrivals.begin(), arrivals.end(), std::size_t{0});
}

StateKinds state_kinds(const ArrivalSource& source, const Site& site) {
  const TrajectoryModel model = trajectory_model(site);
  StateKinds kinds(source.runs());
  for (std::size_t run = 0; run < kinds.size(); ++run)
    for (std::size_t v = 0; v < site.vehicles.size(); ++v)
      kinds[run].push_back(state_kind(source.log(run), VehicleId(v), model));
  return kinds;
}

ChunkIndex::ChunkIndex(StateKinds kinds, std::size_t beacons, std::size_t chunk_arrivals)
    : kinds_(std::move(kinds)),
      vehicles_(kinds_.empty() ? 0 : kinds_.front().size()),
      beacons_(beacons),
      chunk_arrivals_(chunk_arrivals) {}

bool ChunkIndex::OpenGroup::ends_state(StateKind kind, const Arrival& a) const {
  const bool is_epoch = kind == StateKind::kStops || kind == StateKind::kChainedStops;
  return is_epoch ? epoch != a.epoch : time_s != a.time_s;
}

bool ChunkIndex::OpenGroup::ends(StateKind kind, const Arrival& a) const {
  if (!any) return true;
  return kind == StateKind::kStops ? epoch != a.epoch : a.time_s - time_s > longest_tie_s(kind);
}

void ChunkIndex::add(std::size_t run, const std::vector<Arrival>& block) {
  while (runs_.size() <= run) begin_run();
  RunStates& r = runs_.back();
  const std::size_t b = r.first_state.size();
  r.first_state.push_back(r.states);
  if (chunk_size_ >= chunk_arrivals_) begin_chunk(b);
  chunks_.back().last_block = b + 1;
  for (const Arrival& a : block) {
    const StateKind kind = kinds_[run][a.vehicle.index()];
    if (kind == StateKind::kDrive) continue;
    OpenGroup& open = open_[a.vehicle.index()];
    const bool is_new = open.ends(kind, a), is_new_state = is_new || open.ends_state(kind, a);
    if (is_new) open = {true, a.epoch, a.time_s, a.time_s, b, chunks_.size() - 1, {}};
    if (open.block < b) continue_group(r, open, kind, b, a);
    open.epoch = a.epoch;
    open.time_s = a.time_s;
    r.states += is_new_state;
    chunks_[open.chunk].states[a.vehicle.index()] += is_new_state;
    ++chunks_[open.chunk].arrivals[a.vehicle.index()];
    ++r.heard[a.beacon.index()];
    ++chunk_size_;
    ++arrivals_;
  }
}

void ChunkIndex::end(std::size_t runs) {
  while (runs_.size() < runs) begin_run();
  end_run();
  std::vector<std::size_t> states, arrivals;
  for (Chunk& chunk : chunks_) {
    if (chunk.first_block == 0) {
      states.assign(vehicles_, 0);
      arrivals.assign(vehicles_, 0);
    }
    chunk.states_before = states;
    chunk.arrivals_before = arrivals;
    for (std::size_t v = 0; v < vehicles_; ++v) {
      states[v] += chunk.states[v];
      arrivals[v] += chunk.arrivals[v];
    }
  }
  std::erase_if(chunks_, [](const Chunk& chunk) { return chunk.all_arrivals() == 0; });
}

/// In another block.
void ChunkIndex::continue_group(RunStates& run, OpenGroup& open, StateKind kind, std::size_t block,
                                const Arrival& a) {
  if (!open.split) {
    open.split = run.splits.size();
    run.splits.push_back({open.block, block, a.vehicle, kind, a.epoch, open.from_s, a.time_s});
  }
  run.splits[*open.split].last_block = block;
  run.splits[*open.split].until_s = a.time_s;
}

void ChunkIndex::begin_run() {
  end_run();
  runs_.emplace_back().heard.assign(beacons_, 0);
  open_.assign(vehicles_, {});
  begin_chunk(0);
}

void ChunkIndex::begin_chunk(std::size_t block) {
  const std::vector<std::size_t> none(vehicles_, 0);
  chunks_.push_back({runs_.size() - 1, block, block, none, none, {}, {}});
  chunk_size_ = 0;
}

void ChunkIndex::end_run() {
  if (runs_.empty()) return;
  RunStates& r = runs_.back();
  const std::size_t blocks = r.first_state.size();
  r.first_state.push_back(r.states);
  std::vector<std::uint32_t> count(blocks + 1, 0);
  for (const SplitGroup& s : r.splits)
    for (std::size_t b = s.first_block + 1; b <= s.last_block; ++b) ++count[b];
  r.first_open.assign(blocks + 2, 0);
  for (std::size_t b = 0; b <= blocks; ++b) r.first_open[b + 1] = r.first_open[b] + count[b];
  r.open.resize(r.first_open.back());
  std::vector<std::uint32_t> next(r.first_open.begin(), r.first_open.end() - 1);
  for (std::size_t i = 0; i < r.splits.size(); ++i)
    for (std::size_t b = r.splits[i].first_block + 1; b <= r.splits[i].last_block; ++b)
      r.open[next[b]++] = static_cast<std::uint32_t>(i);
}

Result<void> ChunkIndex::read(const ArrivalSource& source, std::size_t run, std::size_t first,
                              std::size_t last, std::vector<Arrival>& arrivals) const {
  const RunStates& r = runs_[run];
  arrivals.clear();
  if (auto ok = source.read(run, first, last, arrivals); !ok) return ok;
  const std::vector<StateKind>& kinds = kinds_[run];
  if (std::ranges::find(kinds, StateKind::kDrive) != kinds.end())
    std::erase_if(arrivals, [&](const Arrival& a) { return kinds[a.vehicle.index()] == StateKind::kDrive; });
  // Groups that began before are another chunk's,
  for (std::size_t k = r.first_open[first]; k < r.first_open[first + 1]; ++k) {
    const SplitGroup& split = r.splits[r.open[k]];
    std::erase_if(arrivals, [&](const Arrival& a) { return split.has(a); });
  }
  // and those that go on beyond the end are this one's.
  std::vector<const SplitGroup*> going_on;
  std::size_t until = last;
  for (std::size_t k = r.first_open[last]; k < r.first_open[last + 1]; ++k) {
    const SplitGroup& split = r.splits[r.open[k]];
    if (split.first_block < first) continue;
    going_on.push_back(&split);
    until = std::max(until, split.last_block + 1);
  }
  if (going_on.empty()) return {};
  const auto own = static_cast<std::ptrdiff_t>(arrivals.size());
  if (auto ok = source.read(run, last, until, arrivals); !ok) return ok;
  const auto others = [&](const Arrival& a) {
    return std::ranges::none_of(going_on, [&](const SplitGroup* s) { return s->has(a); });
  };
  arrivals.erase(std::remove_if(arrivals.begin() + own, arrivals.end(), others), arrivals.end());
  return {};
}

}  // namespace octant::calib
