// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/problem.h"
#include "models/trajectory/shared_state.h"

namespace octant::calib {

/// A map frame made from the recordings alone, for sites of which no position is known.
struct ColdStart {
  bool ok = false;
  double uncertainty_m = 0.0;  ///< how far ranges may be off in it
};

/// One epoch becomes the origin of the map: an array of receivers sees range and bearing of each beacon it
/// hears, so the best-hearing epoch places its beacons around itself (above the receivers, where motion is
/// planar). Marks those beacons found and that epoch placed.
[[nodiscard]] ColdStart start_from_array(const Problem& problem, SharedState& state,
                                         std::vector<Trajectory>& trajectories,
                                         std::vector<bool>& beacon_found, double typical_range_m);

/// The odometry of the longest drive becomes the map: its states are placed along the odometry path from the
/// origin.
[[nodiscard]] ColdStart start_from_odometry(const Problem& problem, std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
