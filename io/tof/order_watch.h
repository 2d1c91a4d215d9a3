// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: rules for consecutive rows of a run.

#include <cstdint>
#include <limits>
#include <vector>

#include <boost/icl/interval_set.hpp>

#include "io/text/csv.h"
#include "io/tof/continued_clock.h"
#include "models/ids.h"
#include "models/run.h"

namespace octant::io {

/// Checks that time does not decrease and that each epoch is one block for each vehicle.
class OrderWatch {
 public:
  OrderWatch(std::size_t vehicles, int time_column, int epoch_column);

  // Next value; false, without a change of state, if it is out of order.
  [[nodiscard]] bool advance_time(double time_s) {
    if (time_s < times_.last_time_s) return false;
    times_.last_time_s = time_s;
    return true;
  }
  [[nodiscard]] bool advance_epoch(VehicleId vehicle, std::int64_t epoch) {
    return epoch == current_[vehicle.index()] || begin_epoch(vehicle, epoch);
  }

  /// Checks the time of a row of a file. A clock that starts again is continued, in `time_s`.
  /// Returns false after logging an error at the column.
  bool time(CsvReader& csv, double& time_s);
  /// Checks the epoch of a row of a file; false after logging an error at the column.
  bool epoch(CsvReader& csv, VehicleId vehicle, std::int64_t epoch);

  /// Times of the rows so far, with which another watch goes on.
  struct Times {
    ContinuedClock restarts;
    double last_time_s = -std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] const Times& times() const { return times_; }
  void go_on(const Times& times) { times_ = times; }

 private:
  bool begin_epoch(VehicleId vehicle, std::int64_t epoch);

  int time_column_, epoch_column_;
  Times times_;
  std::vector<std::int64_t> current_;  // by vehicle
  // By vehicle. Millions of epochs in mostly increasing order are a few intervals.
  std::vector<boost::icl::interval_set<std::int64_t>> finished_;
};

}  // namespace octant::io
