// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include "models/localizers/least_squares/search_problem.h"

namespace octant {

/// The odometry of a window as a rigid piece: poses of its nodes in the frame of one of them, and their drift
/// away from it. In the plane and in space.
[[nodiscard]] RigidPath rigid_path(const Trajectory& trajectory, const Segment& window, std::size_t anchor);

/// Puts a window's nodes where the pose of its anchor has them.
void lay_rigidly(Trajectory& trajectory, const Segment& window, const Pose& T_map_anchor,
                 const RigidPath& path);

/// Puts the nodes from one that is placed to an end of the segment where odometry has them, or those of so
/// many seconds.
/// @return the last of them
std::size_t follow_odometry(Trajectory& trajectory, const Segment& segment, std::size_t node, bool forward,
                            double span_s = INFINITY);

/// Evenly fewer ranges, so that a long window costs no more to search; those of a window are independent, so
/// groups are of no matter beyond the bookkeeping.
void thin_out(SearchProblem& problem);

}  // namespace octant
