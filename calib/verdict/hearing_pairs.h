// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "models/deployment.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Visits pairs of a state with arrivals (every `stride`-th state) and a beacon that is determined.
/// @param is_heard  returns true if an arrival counts
/// @param take  called with the beacon, its distance [m] and true if it was received
template <class IsHeard, class Take>
void for_each_hearing_pair(const Trajectory& t, const std::vector<DeploymentBeacon>& beacons,
                           std::size_t stride, const IsHeard& is_heard, const Take& take) {
  std::vector<bool> heard(beacons.size());
  std::size_t a = 0;
  for (std::size_t n = 0; n < t.nodes.size(); ++n) {
    while (a < t.arrivals.size() && t.arrivals[a].node < n) ++a;
    if (n % stride != 0 || !t.nodes[n].placed) continue;
    std::fill(heard.begin(), heard.end(), false);
    bool any = false;
    for (; a < t.arrivals.size() && t.arrivals[a].node == n; ++a)
      if (is_heard(t.arrivals[a])) heard[t.arrivals[a].beacon.index()] = any = true;
    if (!any) continue;  // no arrivals at this state
    for (std::size_t b = 0; b < beacons.size(); ++b)
      if (beacons[b].status != BeaconStatus::kUndetermined && beacons[b].position_m.allFinite())
        take(b, (beacons[b].position_m - t.nodes[n].T_map_vehicle.translation_m).norm(), heard[b]);
  }
}

}  // namespace octant::calib
