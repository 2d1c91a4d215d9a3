// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/linearise.h"

namespace octant {

/// As fix_epoch, without its search where that could find nothing better: linear ranges place a planar node
/// in closed form, it is adjusted, and if then all arrivals but a few echoes agree, of three beacons and more
/// that are not in line, over seven paths and more, and they tell the heading, that is the fix. Else the
/// search starts where the linear ranges are, and looks only for poses that explain the arrivals as well
/// (rivals.h); without linear ranges, fix_epoch.
void fix_directly(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                  const EpochFixOptions& options, Fix& fix);

/// Covariance of the pose of an adjusted node, noise alone; false where the position is not determined. A
/// heading without information gets the sigma pi.
bool pose_covariance(const Trajectory& trajectory, const NodeBlock& information, PoseCovariance& covariance);

}  // namespace octant
