// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/localizers/drive/tracker.h"

namespace octant {

/// place_stretch in space: the odometry of a stretch is a rigid piece of six degrees of freedom, settled
/// under a one-sided loss from a coarse set of rotations, beside it beacons that are known roughly
/// (range_slack_m) as unknowns; its states then follow. False where the arrivals do not tell one pose clearly
/// from all others, attitude included: the stretch has to grow, until the path bends.
///
/// Beacons in one plane leave a mirror image of a path along it: taken is the one below the beacons if that
/// is above the floor (z = 0), as without odometry (space_track.h).
[[nodiscard]] bool place_stretch_in_space(Trajectory& trajectory, const Segment& stretch,
                                          const EpochFixModel& model, const TrackerOptions& options);

/// Follows the odometry from a node that is placed to an end of the segment, piece by piece: each is settled
/// robustly with some seconds of what is placed. Where beacons are known roughly (range_slack_m) odometry is
/// all that is followed.
/// @return the last node that was reached: forward another than the end where most arrivals no longer agree
[[nodiscard]] std::size_t follow_in_space(Trajectory& trajectory, const Segment& segment,
                                          const EpochFixModel& model, const TrackerOptions& options,
                                          std::size_t node, bool forward);

}  // namespace octant
