// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/chain/chain_paths.h"

#include <algorithm>

namespace octant::calib {

ChainPaths::ChainPaths(const Trajectory& trajectory, const ParameterLayout& layout,
                       const std::vector<std::size_t>& segments)
    : trajectory_(&trajectory), layout_(&layout), receivers_(layout.receiver.size()) {
  path_of_.assign(layout.beacon.size() * receivers_, -1);
  for (const std::size_t s : segments) {
    const Segment& segment = trajectory.segments[s];
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
      const std::size_t b = trajectory.arrivals[i].beacon.index(),
                        r = trajectory.arrivals[i].receiver.index();
      std::int32_t& path = path_of_[b * receivers_ + r];
      if (path >= 0) continue;
      path = static_cast<std::int32_t>(paths_.size());
      PathColumns& columns =
          paths_.emplace_back(path_columns(layout, BeaconId(b), ReceiverId(r), trajectory.run));
      // Ascending, as the columns of the system are.
      std::sort(columns.entry.begin(), columns.entry.begin() + static_cast<std::ptrdiff_t>(columns.count),
                [](const auto& x, const auto& y) { return x.column < y.column; });
    }
  }
}

}  // namespace octant::calib
