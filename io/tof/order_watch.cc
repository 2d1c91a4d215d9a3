// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/order_watch.h"

#include <fmt/format.h>

namespace octant::io {

OrderWatch::OrderWatch(std::size_t vehicles, int time_column, int epoch_column)
    : time_column_(time_column),
      epoch_column_(epoch_column),
      current_(vehicles, kNoEpoch),
      finished_(vehicles) {}

bool OrderWatch::begin_epoch(VehicleId vehicle, std::int64_t epoch) {
  auto& finished = finished_[vehicle.index()];
  if (boost::icl::contains(finished, epoch)) return false;
  std::int64_t& current = current_[vehicle.index()];
  if (current != kNoEpoch) finished.add(current);
  current = epoch;
  return true;
}

bool OrderWatch::time(CsvReader& csv, double& time_s) {
  const double stated_s = time_s;
  time_s = times_.restarts.continued(stated_s, times_.last_time_s, csv.line());
  if (advance_time(time_s)) return true;
  return csv.fail_at(time_column_,
                     fmt::format("time_s goes back from {} to {}",
                                 exact(times_.last_time_s - times_.restarts.offset_s()), exact(stated_s)),
                     "times that do not decrease", "sort the rows by time_s");
}

bool OrderWatch::epoch(CsvReader& csv, VehicleId vehicle, std::int64_t epoch) {
  if (advance_epoch(vehicle, epoch)) return true;
  return csv.fail_at(
      epoch_column_, fmt::format("epoch {} comes back after epoch {}", epoch, current_[vehicle.index()]),
      "the rows of an epoch in one block", "give each stop of the vehicle a number of its own");
}

}  // namespace octant::io
