// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Initial poses and velocities of a segment with a motion prior (Trajectory::motion_prior). Short windows
/// are searched as for a vehicle at rest, with an uncertainty that covers its motion, and connected by
/// straight lines. Sets the nodes of the segment; returns false if no window determines a pose.
[[nodiscard]] bool place_by_motion(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                   const TrackerOptions& options);

}  // namespace octant
