// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/drive/odometry_track.h"
#include "models/localizers/line_map/line_map.h"
#include "models/support/scratch.h"

namespace octant {

/// A segment of a scan held against a wall: how far it is off, square to the wall at the segment's centre and
/// in angle.
struct WallObservation {
  Eigen::Matrix<double, 2, 3> H = Eigen::Matrix<double, 2, 3>::Zero();  ///< by the pose (x, y, heading)
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  ///< m, rad: what the pose should change
  Eigen::Vector2d noise = Eigen::Vector2d::Ones();     ///< variances of the segment's own
};
[[nodiscard]] WallObservation observe_wall(const OdometryState& pose, const LineSegment& segment,
                                           const LineSegment& wall, const LineMapOptions& options);

/// Which wall each segment of a scan is (-1: none), and the pose that follows.
struct WallMatches {
  std::pmr::vector<int> wall{scratch()};
  OdometryState state;  ///< prior and matched segments together; its covariance without the walls' own
  Eigen::Matrix3d wall_spread = Eigen::Matrix3d::Zero();  ///< sum of H' W M W H, M the walls' own covariance
  double cost = 0.0;                                      ///< minus twice the log likelihood
  int matched = 0;
};

/// All ways in which the segments of a scan may be walls of the map, none at all included: every single match
/// that the prior allows is taken as a seed, and the pose that it gives decides on the others. Likely is,
/// besides small residuals, what was to be expected: a match that a wide prior would allow anywhere says
/// little, three that meet in one pose say much. A segment that is no wall of the map (clutter) lies anywhere
/// within the gates. All of the scan's points, not its segments alone, then check each pose: points on walls
/// speak for it, beams that went through walls speak against it.
[[nodiscard]] std::pmr::vector<WallMatches> match_walls(const OdometryState& prior,
                                                        std::span<const LineSegment> segments,
                                                        std::span<const Eigen::Vector2d> points,
                                                        const LineMap& map, const LineMapOptions& options);

/// Points of a scan held against the map from a pose.
struct MapSupport {
  int points = 0;
  int on_wall = 0;  ///< within hit_m of a wall
  int through = 0;  ///< behind a wall
};
[[nodiscard]] MapSupport map_support(const OdometryState& pose, std::span<const Eigen::Vector2d> points,
                                     const LineMap& map, std::span<const int> walls,
                                     const LineMapOptions& options);

}  // namespace octant
