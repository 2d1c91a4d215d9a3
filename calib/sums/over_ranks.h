// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "calib/sums/log_buffer.h"
#include "calib/sums/ranks.h"
#include "calib/sums/reduced_system.h"

namespace octant::calib {

/// Parts of a log that a rank reads, [first, last): equal numbers, consecutive.
inline std::pair<std::size_t, std::size_t> parts_of(const Ranks* ranks, std::size_t parts) {
  if (ranks == nullptr) return {0, parts};
  const auto count = static_cast<std::size_t>(ranks->count()),
             index = static_cast<std::size_t>(ranks->index());
  return {index * parts / count, (index + 1) * parts / count};
}

inline void sum_over(const Ranks* ranks, std::vector<double>& numbers) {
  if (ranks != nullptr) ranks->sum(numbers);
}
/// Adds up each number of a record (log_buffer.h), which has the same size on all ranks.
template <class Record>
void sum_over(const Ranks* ranks, Record& record) {
  if (ranks == nullptr) return;
  std::vector<double> numbers;
  BufferWriter writer(numbers);
  exchange(writer, record);
  ranks->sum(numbers);
  BufferReader reader(numbers);
  exchange(reader, record);
}

/// A system of the same columns on all ranks.
template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<ReducedSystem> auto&& system) {
  buffer.exchange(system.cost, system.gradient, system.H);
}

/// Lists of all parts of all ranks, one behind the other in the order of the parts.
inline std::vector<double> in_order(const Ranks* ranks, std::vector<std::vector<double>> of_parts) {
  std::vector<double> mine;
  for (std::vector<double>& list : of_parts) {
    mine.insert(mine.end(), list.begin(), list.end());
    list = {};
  }
  if (ranks == nullptr) return mine;
  std::vector<double> sizes(static_cast<std::size_t>(ranks->count()), 0.0);
  const auto rank = static_cast<std::size_t>(ranks->index());
  sizes[rank] = static_cast<double>(mine.size());
  sum_over(ranks, sizes);
  const auto sum_until = [&](std::size_t i) {
    return static_cast<std::size_t>(
        std::accumulate(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(i), 0.0));
  };
  std::vector<double> all(sum_until(sizes.size()), 0.0);
  std::ranges::copy(mine, all.begin() + static_cast<std::ptrdiff_t>(sum_until(rank)));
  sum_over(ranks, all);
  return all;
}

/// Sums systems with different columns on each rank.
inline void sum_over(const Ranks* ranks, SystemParts& data) {
  if (ranks == nullptr) return;
  std::vector<std::vector<double>> mine(1);
  BufferWriter writer(mine.front());
  for (const SystemPart& part : data.parts()) writer.exchange(part.columns, part.system);
  const std::vector<double> all = in_order(ranks, std::move(mine));
  BufferReader reader(all);
  data = {};
  while (!reader.ended()) {
    std::vector<int> columns;
    reader.exchange(columns);
    SystemPart part = empty_part(std::move(columns));
    reader.exchange(part.system);
    data.add(std::move(part));
  }
}

}  // namespace octant::calib
