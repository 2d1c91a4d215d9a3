// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/order_watch.h"

#include <algorithm>

#include <fmt/format.h>

namespace octant::io {

void NumberSet::insert(std::int64_t number) {
  if (!intervals_.empty() && number <= intervals_.back().second) {
    if (!contains(number)) others_.insert(number);
  } else if (!intervals_.empty() && number == intervals_.back().second + 1) {
    intervals_.back().second = number;
  } else {
    intervals_.emplace_back(number, number);
  }
}

bool NumberSet::contains(std::int64_t number) const {
  if (intervals_.empty() || number > intervals_.back().second) return false;
  const auto after =
      std::ranges::upper_bound(intervals_, number, {}, &decltype(intervals_)::value_type::first);
  return (after != intervals_.begin() && number <= std::prev(after)->second) || others_.contains(number);
}

OrderWatch::OrderWatch(std::size_t vehicles, int time_column, int epoch_column)
    : time_column_(time_column),
      epoch_column_(epoch_column),
      current_(vehicles, kNoEpoch),
      finished_(vehicles) {}

bool OrderWatch::begin_epoch(VehicleId vehicle, std::int64_t epoch) {
  NumberSet& finished = finished_[vehicle.index()];
  if (finished.contains(epoch)) return false;
  std::int64_t& current = current_[vehicle.index()];
  if (current != kNoEpoch) finished.insert(current);
  current = epoch;
  return true;
}

bool OrderWatch::time(CsvReader& csv, double time_s) {
  if (advance_time(time_s)) return true;
  return csv.fail_at(time_column_,
                     fmt::format("time_s goes back from {} to {}", exact(last_time_s_), exact(time_s)),
                     "times that do not decrease", "sort the rows by time_s");
}

bool OrderWatch::epoch(CsvReader& csv, VehicleId vehicle, std::int64_t epoch) {
  if (advance_epoch(vehicle, epoch)) return true;
  return csv.fail_at(
      epoch_column_, fmt::format("epoch {} comes back after epoch {}", epoch, current_[vehicle.index()]),
      "the rows of an epoch in one block", "give each stop of the vehicle a number of its own");
}

}  // namespace octant::io
