// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant {

/// Initial pose of a stop by linear least squares. The ranges to three or more beacons give
///   -2 b.p + |p|^2 = r^2 - |b|^2
/// as in Figueroa and Mahajan (1994). The differences between ranges then give a correction and (cos, sin) of
/// the heading. Requires synchronised clocks and one-way ranging; arrivals marked kTriangle are ignored.
/// Returns false and leaves the node unchanged if the beacons do not determine the pose (too few, or
/// collinear).
[[nodiscard]] bool place_by_linear_ranges(Trajectory& trajectory, const Segment& segment,
                                          const SharedState& state, const std::vector<bool>& beacon_usable);

/// Marks arrivals that came to a receiver by a detour as kTriangle: the range exceeds that of another
/// receiver from the same beacon plus the distance between the receivers (triangle inequality) by more than a
/// number of sigmas. For one vehicle state with up to 200 arrivals. Returns true if there were any.
[[nodiscard]] bool reject_detours(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                                  double sigmas);

}  // namespace octant
