// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include "models/localizers/least_squares/search_problem.h"

namespace octant {

/// Odometry of a window as a rigid piece: poses of its nodes relative to an anchor node, and their drift. For
/// planar and spatial motion.
[[nodiscard]] RigidPath rigid_path(const Trajectory& trajectory, const Segment& window, std::size_t anchor);

/// Sets the nodes of a window from the pose of its anchor.
void lay_rigidly(Trajectory& trajectory, const Segment& window, const Pose& T_map_anchor,
                 const RigidPath& path);

/// Extends a known node by odometry to an end of the segment, or for a limited time.
/// @return the last node that was set
std::size_t follow_odometry(Trajectory& trajectory, const Segment& segment, std::size_t node, bool forward,
                            double span_s = INFINITY);

/// Thins out ranges evenly, so that the cost of a search does not grow with the window. The ranges of a drive
/// are independent, so this does not affect their grouping by beacon.
void thin_out(SearchProblem& problem);

}  // namespace octant
