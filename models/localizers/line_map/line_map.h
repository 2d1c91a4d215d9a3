// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/line_map/scan_lines.h"
#include "models/run.h"
#include "models/support/result.h"

namespace octant {

/// A wall of the stored map.
struct MapLine {
  LineSegment segment;  ///< in the map
  int scans = 1;        ///< in which it was seen; 0: given
};

/// The stored map: straight walls.
struct LineMap {
  std::vector<MapLine> lines;
};

struct LineMapOptions {
  ScanLineOptions scan;
  // Of the map.
  LinkGate join = {};  ///< segments that are one wall
  int min_scans = 2;   ///< a wall seen in fewer is none
  double min_wall_m = 0.5;
  // Of a correction.
  double range_sigma_m = 0.02;  ///< of a beam; a segment's own scatter where that is more
  double line_sigma_m = 0.01;   ///< of a segment, however many beams: edges, clutter, unevenness
  double line_sigma_rad = 0.005;
  double map_sigma_m = 0.04;  ///< of a wall on the map, which does not average out while the vehicle sees it
  double map_sigma_rad = 0.01;
  double step_sigma_m = 0.05;  ///< from scan to scan, beside the noise stated of the odometry: slip, timing
  double step_sigma_rad = 0.02;
  double turn_sigma_per_rad = 0.1;       ///< of a turn, where the odometry states less
  double gate_probability_sigmas = 3.7;  ///< of offset and angle together (3.7: one in a thousand lost)
  double max_offset_m = 1.0;             ///< whatever the covariance
  double max_angle_rad = 0.35;
  double clutter_share = 0.2;  ///< of a scan's segments that are no wall of the map
  double ambiguity_margin =
      6.0;  ///< of minus twice the log likelihood: another pose that near the best makes a fix ambiguous
  int max_hypotheses = 6;       ///< poses that are followed until one has explained the scans best
  double forget_margin = 30.0;  ///< of minus twice the log likelihood, beyond which a pose is given up
  // Of the check by all points (neighbouring beams are no independent witnesses).
  int support_every = 4;  ///< every so many points
  double hit_m = 0.1;     ///< a point nearer to a wall is on it
  double on_wall_gain =
      2.0;  ///< in minus twice the log likelihood, each point beyond the share that chance would bring
  double chance_share = 0.4;
  double through_cost = 1.0;
  double max_sigma_m = 2.0;  ///< horizontal; beyond it there is no fix
  // Off the map nothing of a scan need be on it, and what is by chance must not make a fix.
  double least_on_wall = 0.4;  ///< share of the latest scans' points on walls, below which there is no fix
  double on_wall_scans = 8.0;  ///< over about so many scans
};

/// Map from scans at known poses of the sensor; segments that may be parts of one wall are added up.
[[nodiscard]] LineMap build_line_map(std::span<const Scan> scans, std::span<const Pose> T_map_sensor,
                                     const LineMapOptions& options = {});
/// The same from a run with measured poses (poses.tum), of which those at the scans' times are taken,
/// interpolated over gaps of at most pose_accuracy.max_gap_s. An error says what the run lacks.
[[nodiscard]] Result<LineMap> build_line_map(const MeasurementLog& log, const LineMapOptions& options = {});
/// A wall from end to end, as drawn on a plan.
[[nodiscard]] MapLine wall(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m);

/// What a run needs to be located on a line map: scans, odometry and a first pose. An error says what it
/// lacks.
[[nodiscard]] Result<void> line_map_fits(const LineMap& map, const MeasurementLog& log);

}  // namespace octant
