// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "models/fix.h"
#include "models/localizers/chain/chain_windows.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/trajectory.h"

namespace octant {

struct DriveUncertaintyOptions {
  bool protect = false;  ///< compute protection levels (chain_protection.h)
  int threads = 1;
};

/// Sets the covariances of a smoothed drive's fixes, including the calibration (chain_calibration.h), and
/// protection levels on request: 0 throughout a drive that is lost without one of its beacons.
/// @param trajectory  solved
/// @param instants  in order of nodes
/// @param fixes  one for each instant; poor geometry if the observations do not determine all states
void set_uncertainty(const Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                     const CalibrationPart& calibration, const DriveUncertaintyOptions& options,
                     std::span<const DriveInstant> instants, std::span<Fix> fixes);

}  // namespace octant
