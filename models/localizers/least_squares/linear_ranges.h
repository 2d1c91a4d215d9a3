// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant {

/// Pose of a stop by linear least squares, good enough to be settled from: the ranges to three and more
/// beacons give
///   -2 b.p + |p|^2 = r^2 - |b|^2
/// as in Figueroa and Mahajan (1994), then the ranges' differences give a correction and (cos, sin) of the
/// heading. Synchronised clocks, one way; arrivals marked kTriangle take no part. False where the beacons do
/// not tell (too few, in line); the node is then left as it is.
[[nodiscard]] bool place_by_linear_ranges(Trajectory& trajectory, const Segment& segment,
                                          const SharedState& state, const std::vector<bool>& beacon_usable);

/// Marks kTriangle what came to a receiver over a detour: its range is longer than that of another receiver
/// from the same beacon and their distance together (triangle inequality), by more than so many sigmas. One
/// vehicle state, up to 200 arrivals. Returns whether there were any.
[[nodiscard]] bool reject_detours(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                                  double sigmas);

}  // namespace octant
