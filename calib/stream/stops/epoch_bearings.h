// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>
#include <vector>

#include "models/run.h"

namespace octant::calib {

/// The bearings of a run by the epochs to which they belong.
class EpochBearings {
 public:
  explicit EpochBearings(const std::vector<Bearing>& bearings);

  /// Numbers in the run, ascending, of the bearings of all epochs that some of these arrivals belong to.
  [[nodiscard]] std::vector<std::size_t> of_epochs_in(const std::vector<Arrival>& arrivals) const;

 private:
  using Row = std::tuple<VehicleId, std::int64_t, std::size_t>;  ///< vehicle, epoch, number
  std::vector<Row> rows_;
};

}  // namespace octant::calib
