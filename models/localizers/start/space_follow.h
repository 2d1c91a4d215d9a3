// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// What became of the pieces of a path among beacons that are known roughly.
struct RoughPieces {
  std::vector<PoseObservation> poses;  ///< where each that was solved has its middle, to the uncertainty
  double cost = 0.0;                   ///< negative log likelihood of what they hear
  std::size_t reached = 0;             ///< the last node
};

/// Follows the odometry from a node that is placed to an end of the segment, among beacons that are known
/// roughly (range_uncertainty_m): piece by piece, each solved as a rigid piece with the beacons free within
/// the uncertainty, from where the last one and odometry expect it, so that what odometry loses does not add
/// up. Forward only as far as arrivals agree.
[[nodiscard]] RoughPieces follow_roughly(Trajectory& trajectory, const Segment& segment,
                                         const EpochFixModel& model, const TrackerOptions& options,
                                         std::size_t node, bool forward);

/// A pose as well known as that of a piece among beacons that are off by the uncertainty.
[[nodiscard]] PoseObservation rough_pose(const Trajectory& trajectory, std::size_t node,
                                         double uncertainty_m);

/// Pieces leave kinks where they meet, and arrivals tell little of attitude: solved from there by both, a
/// path may end as a tilted image of itself. So odometry and the pieces' middles alone are solved first.
void join_pieces(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                 const std::vector<PoseObservation>& pieces, int threads);

}  // namespace octant
