// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Initial poses and velocities of a segment that a motion prior ties together (Trajectory::motion_prior):
/// short windows are searched as if the vehicle stood, with as much uncertainty as it may have moved
/// meanwhile, and joined by straight lines. Sets the segment's nodes; false where no window tells a pose.
[[nodiscard]] bool place_by_motion(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                   const TrackerOptions& options);

}  // namespace octant
