// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Places the states of a drive in space among beacons that are known roughly (range_uncertainty_m): a
/// stretch that is placed (space_start.h), the odometry followed from there both ways by pieces that move as
/// one (space_follow.h), as a filter's steps would each bend to the errors of the beacons heard; then
/// odometry and pieces together.
///
/// A stretch is short where odometry is to keep its shape, and beacons that may be anywhere within the
/// uncertainty then explain what is heard from other poses nearly as well, tilted ones above all. Where
/// several are as likely each is followed for a minute, and the one that explains all of that clearly best is
/// taken.
/// @return whether anything was placed
[[nodiscard]] bool place_roughly(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                 const TrackerOptions& options);

}  // namespace octant
