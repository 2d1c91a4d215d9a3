// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/least_squares/search_problem.h"
#include "models/localizers/start/tracker_options.h"
#include "models/physics/pose.h"

namespace octant {

/// Candidate pose of the anchor of a part.
struct LikelyPose {
  Pose T_map_anchor;
  double cost = 0.0;   ///< negative log likelihood of the arrivals, up to a constant
  bool tight = false;  ///< true if linearisation is safe there
};

/// Candidate poses of a part, best first, up to a margin below the best likelihood. Its odometry is a rigid
/// piece with six degrees of freedom, solved under a one-sided loss from a coarse set of rotations. Roughly
/// known beacons (range_uncertainty_m) are additional unknowns. Empty if there are too few arrivals or no
/// pose explains them.
///
/// For coplanar beacons a path has a mirror image. The one below the beacons is kept if it is above the floor
/// (z = 0), as without odometry (space_track.h).
/// @param path  poses of the part relative to its anchor
[[nodiscard]] std::vector<LikelyPose> likely_poses(const Trajectory& trajectory, const Segment& stretch,
                                                   const EpochFixModel& model, const TrackerOptions& options,
                                                   const RigidPath& path, double margin);

/// Spatial version of place_stretch for known beacons: sets the part to its most likely pose and solves its
/// states. Returns false if the arrivals do not determine one pose clearly, including attitude. The part then
/// has to grow until the path bends.
[[nodiscard]] bool place_stretch_in_space(Trajectory& trajectory, const Segment& stretch,
                                          const EpochFixModel& model, const TrackerOptions& options);

}  // namespace octant
