// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "models/fix.h"
#include "models/localizers/drive/chain_calibration.h"
#include "models/localizers/drive/chain_covariance.h"

namespace octant {

/// Horizontal protection levels [m] along a drive that was smoothed, one for each instant: the drive is held
/// against what it would be without each of its beacons (solution separation, as separation.h has it for one
/// fix). With H_i and g_i the information and gradient of all states without the arrivals of beacon i,
///   shift = -H_i^-1 g_i
/// whatever those arrivals are off by, and for however long, the drive without them is not. Linear, from
/// where the drive was solved: shifts count up to some decimetres.
///
/// 0 where the drive is lost without one of the beacons, or lies six sigmas off the drive without it: then
/// that beacon, or those that were left, is at fault.
/// @param trajectory  solved, no arrival marked kBeaconFault; rejections change on the way and are left as
/// they were
/// @param noise  covariance of the states by noise alone
/// @param covariances  of the pose at each instant, calibration's part included: by as much as that widens
/// the noise's, the drive without a beacon is widened too
[[nodiscard]] std::vector<double> chain_protection(Trajectory& trajectory, const Segment& segment,
                                                   const SharedState& state, const ChainCovariance& noise,
                                                   std::span<const DriveInstant> instants,
                                                   std::span<const PoseCovariance> covariances);

}  // namespace octant
