// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/fix.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Horizontal protection level of a fix: how far off it may be with one beacon at fault (all its arrivals of
/// the epoch late or early by the same) by just so much that the others would not notice (0.1 % significance,
/// power 80 %), noise and calibration at 3.29 sigma on top. With A the information of the state, j the sum of
/// a beacon's n derivatives (whitened rows):
///   remaining = n - j A^-1 j',   bias = 4.13 / sqrt(remaining) sigma,   shift = A^-1 j' bias
/// @param covariance  of the fix, calibration's part included
/// @return m; 0 where a beacon's fault could not be noticed at all (two beacons, say): such a fix is not
/// protected
[[nodiscard]] double horizontal_protection_m(const Trajectory& trajectory, const Segment& segment,
                                             const SharedState& state, const PoseCovariance& covariance);

}  // namespace octant
