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

/// Comparison of a segment of a scan with a wall: deviation perpendicular to the wall at the segment's
/// centre, and in angle.
struct WallObservation {
  Eigen::Matrix<double, 2, 3> H =
      Eigen::Matrix<double, 2, 3>::Zero();             ///< derivatives by the pose (x, y, heading)
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  ///< m, rad: correction of the pose
  Eigen::Vector2d noise = Eigen::Vector2d::Ones();     ///< variances of the segment
};
[[nodiscard]] WallObservation observe_wall(const OdometryState& pose, const LineSegment& segment,
                                           const LineSegment& wall, const LineMapOptions& options);

/// Matched wall of each segment of a scan (-1: none), and the resulting pose.
struct WallMatches {
  std::pmr::vector<int> wall{scratch()};
  OdometryState
      state;  ///< estimate from prior and matched segments; its covariance excludes that of the walls
  Eigen::Matrix3d wall_spread =
      Eigen::Matrix3d::Zero();  ///< sum of H' W M W H with the covariance M of the walls
  double cost = 0.0;            ///< minus twice the log likelihood
  int matched = 0;
};

/// Enumerates the consistent matches between the segments of a scan and the walls of the map, including no
/// match at all. Each match that the prior allows is a seed, and the resulting pose determines the other
/// matches. The likelihood combines the residuals with the prior probability of a match: a single match under
/// a wide prior is weak evidence, three that agree in one pose are strong evidence. Segments outside the map
/// (clutter) are uniformly distributed within the gates. Finally all points of the scan check each pose:
/// points on walls support it, beams through walls contradict it.
[[nodiscard]] std::pmr::vector<WallMatches> match_walls(const OdometryState& prior,
                                                        std::span<const LineSegment> segments,
                                                        std::span<const Eigen::Vector2d> points,
                                                        const LineMap& map, const LineMapOptions& options);

/// Agreement of the points of a scan with the map at a pose.
struct MapSupport {
  int points = 0;
  int on_wall = 0;  ///< number within hit_m of a wall
  int through = 0;  ///< number behind a wall
};
[[nodiscard]] MapSupport map_support(const OdometryState& pose, std::span<const Eigen::Vector2d> points,
                                     const LineMap& map, std::span<const int> walls,
                                     const LineMapOptions& options);

}  // namespace octant
