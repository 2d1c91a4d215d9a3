// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>
#include <vector>

#include "models/run.h"
#include "models/trajectory/state_kind.h"

namespace octant::calib {

/// The bearings of a run by the states to which they belong.
class StateBearings {
 public:
  /// @param bearings  by time; they outlive it  @param kinds  of each vehicle's states
  StateBearings(const std::vector<Bearing>& bearings, std::vector<StateKind> kinds);

  /// Numbers in the run, ascending, of the bearings that make_trajectory may give to the states that some of
  /// these arrivals belong to.
  [[nodiscard]] std::vector<std::size_t> of_states_in(const std::vector<Arrival>& arrivals) const;

 private:
  void add_near(VehicleId vehicle, const std::vector<Arrival>& arrivals,
                std::vector<std::size_t>& numbers) const;

  using Row = std::tuple<VehicleId, std::int64_t, std::size_t>;  ///< vehicle, epoch, number
  const std::vector<Bearing>& bearings_;
  std::vector<StateKind> kinds_;
  std::vector<Row> rows_;  ///< of stops
};

}  // namespace octant::calib
