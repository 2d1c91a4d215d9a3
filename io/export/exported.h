// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "io/export/earth.h"
#include "models/fix.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

// Content that `octant export` writes for other programs.
namespace octant::io {

struct ExportedBeacon {
  std::string id;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double sigma_m = 0.0;  ///< horizontal, the larger axis; 0: not known
};

struct ExportedRun {
  MeasurementLog log;
  NameTable names;
};

struct ExportedFixes {
  std::vector<Fix> fixes;
  NameTable names;  ///< vehicles alone
};

struct ExportedContent {
  std::string site;
  std::vector<ExportedBeacon> beacons;
  std::vector<ExportedRun> runs;
  std::vector<ExportedFixes> tracks;
};

/// Reads fixes.csv as `localize --csv` writes it, or a TUM trajectory; the header distinguishes them. Fixes
/// of a TUM file have no covariance. Errors: kBadInput with line and column.
[[nodiscard]] Result<ExportedFixes> read_fixes(const std::string& path);

/// An MCAP file (mcap.dev/spec): chunks with indices, a summary, checksums; read by Foxglove and PlotJuggler.
///   /octant/arrivals/BEACON  octant.Arrival, JSON: the row of tof.csv
///   /octant/odometry         nav_msgs/msg/Odometry, CDR: odometry.csv added up from the first row on
///   /octant/poses, /octant/truth   geometry_msgs/msg/PoseStamped, CDR
///   /octant/fix              geometry_msgs/msg/PoseWithCovarianceStamped, CDR: fixes that are ok
///   /octant/fix_status       octant.Fix, JSON: all fixes, as fixes.csv has them
///   /octant/beacons          foxglove.SceneUpdate, JSON: where the beacons hang
/// run.yaml goes along as metadata; read_bag_log() makes the run again. Several vehicles: /octant/NAME/fix.
/// Errors: kBadInput where a time is before 1970 or after 2200, which MCAP cannot say.
[[nodiscard]] Result<std::string> to_mcap(const ExportedContent& content);

/// A GeoJSON FeatureCollection (RFC 7946: WGS 84, longitude first): beacons and fixes as points with what is
/// known of them, tracks and references as lines.
[[nodiscard]] std::string to_geojson(const ExportedContent& content, const EarthOrigin& origin);

}  // namespace octant::io
