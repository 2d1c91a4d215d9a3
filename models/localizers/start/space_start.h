// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/least_squares/search_problem.h"
#include "models/localizers/start/tracker_options.h"
#include "models/physics/pose.h"

namespace octant {

/// A pose of a stretch's anchor among those that explain what is heard along it.
struct LikelyPose {
  Pose T_map_anchor;
  double cost = 0.0;   ///< negative log likelihood of the arrivals, up to a constant
  bool tight = false;  ///< whether what follows linearises safely there
};

/// Poses of a stretch, best first, none that is less likely than the best by more than the margin: its
/// odometry is a rigid piece of six degrees of freedom, solved under a one-sided loss from a coarse set of
/// rotations, beside it beacons that are known roughly (range_uncertainty_m) as unknowns. Empty where too
/// little is heard, or nothing explains it.
///
/// Beacons in one plane leave a mirror image of a path along it: left is the one below the beacons if that is
/// above the floor (z = 0), as without odometry (space_track.h).
/// @param path  of the stretch from its anchor
[[nodiscard]] std::vector<LikelyPose> likely_poses(const Trajectory& trajectory, const Segment& stretch,
                                                   const EpochFixModel& model, const TrackerOptions& options,
                                                   const RigidPath& path, double margin);

/// place_stretch in space, among known beacons: lays the stretch as its likeliest pose has it and settles its
/// states. False where the arrivals do not tell one pose clearly from all others, attitude included: the
/// stretch has to grow, until the path bends.
[[nodiscard]] bool place_stretch_in_space(Trajectory& trajectory, const Segment& stretch,
                                          const EpochFixModel& model, const TrackerOptions& options);

}  // namespace octant
