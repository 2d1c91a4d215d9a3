// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Result of extending a path among roughly known beacons.
struct RoughPieces {
  std::vector<PoseObservation>
      poses;                ///< pose of the middle of each solved piece, with the uncertainty as sigma
  double cost = 0.0;        ///< negative log likelihood of the arrivals
  std::size_t reached = 0;  ///< last node that was reached
};

/// Extends odometry from a known node to an end of the segment among roughly known beacons
/// (range_uncertainty_m). Each piece is solved as a rigid piece with free beacons within the uncertainty,
/// starting from the previous piece and odometry, so that drift does not accumulate. Stops where arrivals
/// disagree.
[[nodiscard]] RoughPieces follow_roughly(Trajectory& trajectory, const Segment& segment,
                                         const EpochFixModel& model, const TrackerOptions& options,
                                         std::size_t node, bool forward);

/// Pose observation with the accuracy of a piece among beacons with errors of the given size.
[[nodiscard]] PoseObservation rough_pose(const Trajectory& trajectory, std::size_t node,
                                         double uncertainty_m);

/// Solves odometry and the middles of the pieces alone. Pieces have kinks at their ends, and arrivals
/// determine the attitude weakly. If both were used at once, the path could converge to a tilted copy of
/// itself.
void join_pieces(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                 const std::vector<PoseObservation>& pieces, int threads);

}  // namespace octant
