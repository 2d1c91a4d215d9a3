// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/stops/log_index.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace octant::calib {

std::size_t LogChunk::all_arrivals() const {
  return std::accumulate(arrivals.begin(), arrivals.end(), std::size_t{0});
}

/// Follows the rows in the order of the files.
class LogIndex::Scanner {
 public:
  Scanner(std::size_t vehicles, std::size_t beacons, std::size_t chunk_arrivals)
      : vehicles_(vehicles), beacons_(beacons), chunk_arrivals_(chunk_arrivals) {}

  void take(LogIndex& index, std::size_t run, const std::vector<Arrival>& block) {
    while (index.runs_.size() <= run) begin_run(index);
    Run& r = index.runs_.back();
    const std::size_t b = r.first_epoch.size();
    r.first_epoch.push_back(r.epochs);
    if (chunk_size_ >= chunk_arrivals_) begin_chunk(index, b);
    index.chunks_.back().last_block = b + 1;
    for (const Arrival& a : block) {
      Open& open = open_[a.vehicle.index()];
      if (open.epoch != a.epoch || !open.any) {
        open = {true, a.epoch, b, index.chunks_.size() - 1, {}};
        ++r.epochs;
        ++index.chunks_.back().epochs[a.vehicle.index()];
      } else if (open.block < b) {
        if (!open.split) {
          open.split = r.splits.size();
          r.splits.push_back({open.block, b, a.vehicle, a.epoch});
        }
        r.splits[*open.split].last_block = b;
      }
      ++index.chunks_[open.chunk].arrivals[a.vehicle.index()];
      ++r.heard[a.beacon.index()];
    }
    chunk_size_ += block.size();
    index.arrivals_ += block.size();
  }

  void end(LogIndex& index, std::size_t runs) {
    while (index.runs_.size() < runs) begin_run(index);
    end_run(index);
    std::vector<std::size_t> epochs, arrivals;
    for (LogChunk& chunk : index.chunks_) {
      if (chunk.first_block == 0) {
        epochs.assign(vehicles_, 0);
        arrivals.assign(vehicles_, 0);
      }
      chunk.epochs_before = epochs;
      chunk.arrivals_before = arrivals;
      for (std::size_t v = 0; v < vehicles_; ++v) {
        epochs[v] += chunk.epochs[v];
        arrivals[v] += chunk.arrivals[v];
      }
    }
    std::erase_if(index.chunks_, [](const LogChunk& chunk) { return chunk.all_arrivals() == 0; });
  }

 private:
  /// The latest epoch of a vehicle.
  struct Open {
    bool any = false;
    std::int64_t epoch = kNoEpoch;
    std::size_t block = 0, chunk = 0;  ///< in which it began
    std::optional<std::size_t> split;
  };

  void begin_run(LogIndex& index) {
    end_run(index);
    index.runs_.emplace_back().heard.assign(beacons_, 0);
    open_.assign(vehicles_, {});
    begin_chunk(index, 0);
  }

  void begin_chunk(LogIndex& index, std::size_t block) {
    const std::vector<std::size_t> none(vehicles_, 0);
    index.chunks_.push_back({index.runs_.size() - 1, block, block, none, none, {}, {}});
    chunk_size_ = 0;
  }

  void end_run(LogIndex& index) {
    if (index.runs_.empty()) return;
    Run& r = index.runs_.back();
    const std::size_t blocks = r.first_epoch.size();
    r.first_epoch.push_back(r.epochs);
    std::vector<std::uint32_t> count(blocks + 1, 0);
    for (const Split& s : r.splits)
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
  std::vector<Open> open_;  ///< of each vehicle
};

LogIndex::LogIndex(std::size_t vehicles, std::size_t beacons, std::size_t chunk_arrivals)
    : scanner_(std::make_unique<Scanner>(vehicles, beacons, chunk_arrivals)) {}
LogIndex::LogIndex(LogIndex&&) noexcept = default;
LogIndex::~LogIndex() = default;

void LogIndex::take(std::size_t run, const std::vector<Arrival>& block) { scanner_->take(*this, run, block); }

void LogIndex::end(std::size_t runs) {
  scanner_->end(*this, runs);
  scanner_.reset();
}

std::size_t LogIndex::all_epochs() const {
  std::size_t sum = 0;
  for (const Run& run : runs_) sum += run.epochs;
  return sum;
}

Result<void> LogIndex::read(const ArrivalSource& source, std::size_t run, std::size_t first, std::size_t last,
                            std::vector<Arrival>& arrivals) const {
  const Run& r = runs_[run];
  arrivals.clear();
  if (auto ok = source.read(run, first, last, arrivals); !ok) return ok;
  const auto is_of = [](const Arrival& a, const Split& s) {
    return a.epoch == s.epoch && a.vehicle == s.vehicle;
  };
  // Epochs that began before are another stretch's,
  for (std::size_t k = r.first_open[first]; k < r.first_open[first + 1]; ++k) {
    const Split& split = r.splits[r.open[k]];
    std::erase_if(arrivals, [&](const Arrival& a) { return is_of(a, split); });
  }
  // and those that go on beyond the end are this one's.
  std::vector<const Split*> going_on;
  std::size_t until = last;
  for (std::size_t k = r.first_open[last]; k < r.first_open[last + 1]; ++k) {
    const Split& split = r.splits[r.open[k]];
    if (split.first_block < first) continue;
    going_on.push_back(&split);
    until = std::max(until, split.last_block + 1);
  }
  if (going_on.empty()) return {};
  const auto own = static_cast<std::ptrdiff_t>(arrivals.size());
  if (auto ok = source.read(run, last, until, arrivals); !ok) return ok;
  const auto others = [&](const Arrival& a) {
    return std::none_of(going_on.begin(), going_on.end(), [&](const Split* s) { return is_of(a, *s); });
  };
  arrivals.erase(std::remove_if(arrivals.begin() + own, arrivals.end(), others), arrivals.end());
  return {};
}

}  // namespace octant::calib
