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

/// A wall of the map.
struct MapLine {
  LineSegment segment;  ///< in the map frame
  int scans = 1;        ///< number of scans that contain it; 0: given by the user
};

/// Map of straight walls.
struct LineMap {
  std::vector<MapLine> lines;
};

struct LineMapOptions {
  ScanLineOptions scan;
  // Construction of the map.
  LinkGate join = {};  ///< segments that belong to one wall
  int min_scans = 2;   ///< walls in fewer scans are discarded
  double min_wall_m = 0.5;
  // Correction of the pose.
  double range_sigma_m = 0.02;  ///< noise of a beam; the scatter of a segment if that is larger
  double line_sigma_m = 0.01;   ///< systematic error of a segment: edges, clutter, unevenness
  double line_sigma_rad = 0.005;
  double map_sigma_m = 0.04;  ///< error of a wall on the map, which is constant while the vehicle observes it
  double map_sigma_rad = 0.01;
  double step_sigma_m = 0.05;  ///< process noise between scans in addition to the odometry's: slip, timing
  double step_sigma_rad = 0.02;
  double turn_sigma_per_rad = 0.1;       ///< noise of a rotation, if the odometry states less
  double gate_probability_sigmas = 3.7;  ///< gate for offset and angle together (3.7: one in a thousand lost)
  double max_offset_m = 1.0;             ///< upper bound, independent of the covariance
  double max_angle_rad = 0.35;
  double clutter_share = 0.2;     ///< share of a scan's segments that do not belong to the map
  double ambiguity_margin = 6.0;  ///< in minus twice the log likelihood: another pose within this margin of
                                  ///< the best makes a fix ambiguous
  int max_hypotheses = 6;  ///< number of poses that are tracked until one of them explains the scans best
  double forget_margin = 30.0;  ///< in minus twice the log likelihood: poses beyond this margin are dropped
  // Check of the pose by all points; neighbouring beams are not independent.
  int support_every = 4;  ///< subsampling of the points
  double hit_m = 0.1;     ///< largest distance of a point that lies on a wall
  double on_wall_gain =
      2.0;  ///< in minus twice the log likelihood, for each point beyond the share expected by chance
  double chance_share = 0.4;
  double through_cost = 1.0;
  double max_sigma_m = 2.0;  ///< horizontal sigmas above this give no fix
  // Outside the mapped area some points lie on walls by chance, which must not yield a fix.
  double least_on_wall = 0.4;  ///< smallest share of the latest scans' points on walls
  double on_wall_scans = 8.0;  ///< number of scans over which the share is averaged
};

/// Builds a map from scans at known poses of the sensor; segments that may belong to one wall are merged.
[[nodiscard]] LineMap build_line_map(std::span<const Scan> scans, std::span<const Pose> T_map_sensor,
                                     const LineMapOptions& options = {});
/// Builds a map from a run with measured poses (poses.tum), which are interpolated at the times of the scans
/// over gaps of at most pose_accuracy.max_gap_s. The error states what the run lacks.
[[nodiscard]] Result<LineMap> build_line_map(const MeasurementLog& log, const LineMapOptions& options = {});
/// A wall given by its ends, as on a plan.
[[nodiscard]] MapLine wall(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m);

/// Checks the requirements of localization on a line map: scans, odometry and a first pose. The error states
/// what the run lacks.
[[nodiscard]] Result<void> line_map_fits(const LineMap& map, const MeasurementLog& log);

}  // namespace octant
