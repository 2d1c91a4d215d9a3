// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/problem.h"
#include "models/trajectory/shared_state.h"

namespace octant::calib {

/// A map frame from the recordings only, for sites without known positions.
struct ColdStart {
  bool ok = false;
  double uncertainty_m = 0.0;  ///< uncertainty of ranges in it
};

/// One epoch becomes the origin of the map. An array of receivers determines range and bearing of each beacon
/// that it receives, so the epoch with most of them places its beacons around itself (above the receivers in
/// planar motion). Marks these beacons and this epoch as placed.
[[nodiscard]] ColdStart start_from_array(const Problem& problem, SharedState& state,
                                         std::vector<Trajectory>& trajectories,
                                         std::vector<bool>& beacon_found, double typical_range_m);

/// The odometry of the longest drive becomes the map: its states are placed along the odometry path from the
/// origin.
[[nodiscard]] ColdStart start_from_odometry(const Problem& problem, std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
