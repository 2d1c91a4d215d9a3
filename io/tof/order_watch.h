// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: what the rows of a run must keep to from one to the next.

#include <cstdint>
#include <limits>
#include <vector>

#include <boost/icl/interval_set.hpp>

#include "io/text/csv.h"
#include "models/ids.h"
#include "models/run.h"

namespace octant::io {

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
  // By vehicle; millions of epochs that mostly come in increasing order are a few intervals.
  std::vector<boost::icl::interval_set<std::int64_t>> finished_;
};

}  // namespace octant::io
