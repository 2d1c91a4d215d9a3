// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Initial states of a spatial drive among roughly known beacons (range_uncertainty_m). One part is placed
/// (space_start.h), and from there odometry is extended in both directions by rigid pieces (space_follow.h),
/// because single filter steps would follow the errors of the received beacons. Finally odometry and pieces
/// are solved together.
///
/// A part must be short for odometry to preserve its shape. Within the uncertainty of the beacons other
/// poses, above all tilted ones, then explain the arrivals almost equally well. If several are likely, each
/// is extended for a minute, and the one that explains these arrivals clearly best is used.
/// @return true if any part was placed
[[nodiscard]] bool place_roughly(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                 const TrackerOptions& options);

}  // namespace octant
