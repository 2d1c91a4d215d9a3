// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "calib/problem/shared_entries.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Paths from beacons to receivers in segments of a trajectory, each with its columns of the layout.
class ChainPaths {
 public:
  /// @param trajectory, layout  not owned
  ChainPaths(const Trajectory& trajectory, const ParameterLayout& layout,
             const std::vector<std::size_t>& segments);

  /// Paths that some arrival of the segments took.
  [[nodiscard]] const std::vector<PathColumns>& paths() const { return paths_; }
  [[nodiscard]] std::size_t path_of(const ArrivalObservation& a) const {
    return static_cast<std::size_t>(path_of_[a.beacon.index() * receivers_ + a.receiver.index()]);
  }
  [[nodiscard]] const Trajectory& trajectory() const { return *trajectory_; }
  [[nodiscard]] const ParameterLayout& layout() const { return *layout_; }

 private:
  const Trajectory* trajectory_;
  const ParameterLayout* layout_;
  std::size_t receivers_;
  std::vector<std::int32_t> path_of_;  ///< by beacon and receiver; -1: no arrival
  std::vector<PathColumns> paths_;
};

}  // namespace octant::calib
