// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <vector>

#include "models/arrival_source.h"

namespace octant::test {

/// Recordings in memory as a source of small blocks that counts the reads.
class MemorySource : public ArrivalSource {
 public:
  MemorySource(std::vector<MeasurementLog> logs, std::size_t block) : logs_(std::move(logs)), block_(block) {
    for (MeasurementLog& log : logs_) arrivals_.push_back(std::move(log.arrivals));
  }
  [[nodiscard]] std::size_t runs() const override { return logs_.size(); }
  [[nodiscard]] const MeasurementLog& log(std::size_t run) const override { return logs_[run]; }
  [[nodiscard]] Result<void> scan(const Visit& visit) override {
    for (std::size_t run = 0; run < logs_.size(); ++run)
      for (std::size_t first = 0; first < arrivals_[run].size(); first += block_) {
        const std::size_t last = std::min(first + block_, arrivals_[run].size());
        if (!visit(run, {arrivals_[run].begin() + at(first), arrivals_[run].begin() + at(last)})) return {};
      }
    return {};
  }
  [[nodiscard]] Result<void> read(std::size_t run, std::size_t first, std::size_t last,
                                  std::vector<Arrival>& arrivals) const override {
    const auto& all = arrivals_[run];
    const std::size_t begin = std::min(first * block_, all.size()), end = std::min(last * block_, all.size());
    rows_read += end - begin;
    arrivals.insert(arrivals.end(), all.begin() + at(begin), all.begin() + at(end));
    if (forgets && begin == 0) arrivals.erase(arrivals.end() - at(end - begin));
    return {};
  }

  mutable std::atomic<std::size_t> rows_read{0};
  std::atomic<bool> forgets{false};  ///< a row of the first block is gone

 private:
  static std::ptrdiff_t at(std::size_t i) { return static_cast<std::ptrdiff_t>(i); }
  std::vector<MeasurementLog> logs_;
  std::vector<std::vector<Arrival>> arrivals_;
  std::size_t block_;
};

}  // namespace octant::test
