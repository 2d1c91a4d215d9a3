// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: what the rows of a run must keep to from one to the next.

#include <cstdint>
#include <limits>
#include <unordered_set>
#include <utility>
#include <vector>

#include "io/text/csv.h"
#include "models/ids.h"
#include "models/run.h"

namespace octant::io {

/// A set of whole numbers that mostly come in increasing order: a few intervals then hold millions of them.
class NumberSet {
 public:
  void insert(std::int64_t number);
  [[nodiscard]] bool contains(std::int64_t number) const;

 private:
  std::vector<std::pair<std::int64_t, std::int64_t>> intervals_;  // first and last, increasing, apart
  std::unordered_set<std::int64_t> others_;                       // what came too late for them
};

/// Watches that time does not decrease and that each epoch is one block for each vehicle.
class OrderWatch {
 public:
  OrderWatch(std::size_t vehicles, int time_column, int epoch_column);

  // Next value; false, and nothing changes, where it is out of order.
  [[nodiscard]] bool advance_time(double time_s) {
    if (time_s < last_time_s_) return false;
    last_time_s_ = time_s;
    return true;
  }
  [[nodiscard]] bool advance_epoch(VehicleId vehicle, std::int64_t epoch) {
    return epoch == current_[vehicle.index()] || begin_epoch(vehicle, epoch);
  }

  // The same for a row of a file; false after logging an error at the column.
  bool time(CsvReader& csv, double time_s);
  bool epoch(CsvReader& csv, VehicleId vehicle, std::int64_t epoch);

 private:
  bool begin_epoch(VehicleId vehicle, std::int64_t epoch);

  int time_column_, epoch_column_;
  double last_time_s_ = -std::numeric_limits<double>::infinity();
  std::vector<std::int64_t> current_;  // by vehicle
  std::vector<NumberSet> finished_;    // by vehicle
};

}  // namespace octant::io
