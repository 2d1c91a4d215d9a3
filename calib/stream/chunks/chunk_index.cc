// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/chunk_index.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "calib/problem/problem.h"

namespace octant::calib {

std::size_t Chunk::all_arrivals() const {
  return std::accumulate(arrivals.begin(), arrivals.end(), std::size_t{0});
}

/// Follows the rows in the order of the files.
class ChunkIndex::Scanner {
 public:
  Scanner(std::size_t vehicles, std::size_t beacons, std::size_t chunk_arrivals)
      : vehicles_(vehicles), beacons_(beacons), chunk_arrivals_(chunk_arrivals) {}

  void add(ChunkIndex& index, std::size_t run, const std::vector<Arrival>& block) {
    while (index.runs_.size() <= run) begin_run(index);
    RunStates& r = index.runs_.back();
    const std::size_t b = r.first_state.size();
    r.first_state.push_back(r.states);
    if (chunk_size_ >= chunk_arrivals_) begin_chunk(index, b);
    index.chunks_.back().last_block = b + 1;
    const std::vector<StateKind>& kinds = index.kinds_[run];
    for (const Arrival& a : block) {
      const StateKind kind = kinds[a.vehicle.index()];
      if (kind == StateKind::kDrive) continue;
      OpenGroup& open = open_[a.vehicle.index()];
      if (begins_group(kind, open, a)) {
        open = {true, a.epoch, a.time_s, a.time_s, b, index.chunks_.size() - 1, {}};
        begin_state(index, r, open, a);
      } else {
        if (begins_state(kind, open, a)) begin_state(index, r, open, a);
        if (open.block < b) go_on(r, open, kind, b, a);
      }
      open.epoch = a.epoch;
      open.time_s = a.time_s;
      ++index.chunks_[open.chunk].arrivals[a.vehicle.index()];
      ++r.heard[a.beacon.index()];
      ++chunk_size_;
      ++index.arrivals_;
    }
  }

  void end(ChunkIndex& index, std::size_t runs) {
    while (index.runs_.size() < runs) begin_run(index);
    end_run(index);
    std::vector<std::size_t> states, arrivals;
    for (Chunk& chunk : index.chunks_) {
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
    std::erase_if(index.chunks_, [](const Chunk& chunk) { return chunk.all_arrivals() == 0; });
  }

 private:
  /// The latest group of a vehicle.
  struct OpenGroup {
    bool any = false;
    std::int64_t epoch = kNoEpoch;          ///< of its last row
    double time_s = 0.0;                    ///< of that
    double from_s = 0.0;                    ///< of its first row
    std::size_t block = 0, chunk = 0;       ///< in which it began
    std::optional<std::size_t> split = {};  ///< where it lies in several
  };

  static bool begins_state(StateKind kind, const OpenGroup& open, const Arrival& a) {
    const bool is_epoch = kind == StateKind::kStops || kind == StateKind::kChainedStops;
    return is_epoch ? open.epoch != a.epoch : open.time_s != a.time_s;
  }
  static bool begins_group(StateKind kind, const OpenGroup& open, const Arrival& a) {
    if (!open.any) return true;
    return kind == StateKind::kStops ? open.epoch != a.epoch : a.time_s - open.time_s > longest_tie_s(kind);
  }
  static void begin_state(ChunkIndex& index, RunStates& run, const OpenGroup& open, const Arrival& a) {
    ++run.states;
    ++index.chunks_[open.chunk].states[a.vehicle.index()];
  }
  /// In another block.
  static void go_on(RunStates& run, OpenGroup& open, StateKind kind, std::size_t block, const Arrival& a) {
    if (!open.split) {
      open.split = run.splits.size();
      run.splits.push_back({open.block, block, a.vehicle, kind, a.epoch, open.from_s, a.time_s});
    }
    run.splits[*open.split].last_block = block;
    run.splits[*open.split].until_s = a.time_s;
  }

  void begin_run(ChunkIndex& index) {
    end_run(index);
    index.runs_.emplace_back().heard.assign(beacons_, 0);
    open_.assign(vehicles_, {});
    begin_chunk(index, 0);
  }

  void begin_chunk(ChunkIndex& index, std::size_t block) {
    const std::vector<std::size_t> none(vehicles_, 0);
    index.chunks_.push_back({index.runs_.size() - 1, block, block, none, none, {}, {}});
    chunk_size_ = 0;
  }

  void end_run(ChunkIndex& index) {
    if (index.runs_.empty()) return;
    RunStates& r = index.runs_.back();
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

  std::size_t vehicles_, beacons_, chunk_arrivals_;
  std::size_t chunk_size_ = 0;
  std::vector<OpenGroup> open_;  ///< of each vehicle
};

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
      scanner_(
          std::make_unique<Scanner>(kinds_.empty() ? 0 : kinds_.front().size(), beacons, chunk_arrivals)) {}
ChunkIndex::ChunkIndex(ChunkIndex&&) noexcept = default;
ChunkIndex::~ChunkIndex() = default;

void ChunkIndex::add(std::size_t run, const std::vector<Arrival>& block) { scanner_->add(*this, run, block); }

void ChunkIndex::end(std::size_t runs) {
  scanner_->end(*this, runs);
  scanner_.reset();
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
