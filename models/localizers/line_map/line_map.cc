// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/line_map/line_map.h"

#include <algorithm>

#include "models/trajectory/trajectory.h"

namespace octant {
namespace {

tl::unexpected<Error> scans_lack(const MeasurementLog& log, std::string found, std::string expected) {
  return fail({.code = Errc::kBadInput,
               .file = log.path,
               .found = "line_map: " + std::move(found),
               .expected = std::move(expected)});
}

/// Adds a segment to the wall that it may belong to, or as a new wall. Walls that it connects are merged.
void add(std::vector<MapLine>& lines, const LineSegment& segment, const LinkGate& gate) {
  MapLine grown{segment, 1};
  for (std::size_t i = 0; i < lines.size();) {
    if (!may_join(lines[i].segment, grown.segment, gate)) {
      ++i;
      continue;
    }
    grown.segment = joined(lines[i].segment, grown.segment);
    grown.scans += lines[i].scans;
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
    i = 0;  // the grown wall may reach further walls
  }
  lines.push_back(grown);
}

}  // namespace

MapLine wall(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m) {
  const Eigen::Vector2d ends[] = {from_m, to_m};
  return {fit_segment(ends), 0};
}

LineMap build_line_map(std::span<const Scan> scans, std::span<const Pose> T_map_sensor,
                       const LineMapOptions& options) {
  LineMap map;
  for (std::size_t k = 0; k < std::min(scans.size(), T_map_sensor.size()); ++k)
    for (const LineSegment& s : scan_segments(scans[k], options.scan))
      add(map.lines, transformed(s, T_map_sensor[k]), options.join);
  std::erase_if(map.lines, [&](const MapLine& line) {
    return line.scans < options.min_scans || line.segment.length_m() < options.min_wall_m;
  });
  return map;
}

Result<LineMap> build_line_map(const MeasurementLog& log, const LineMapOptions& options) {
  if (log.scans.empty()) return scans_lack(log, "the run has no scans", "scans.csv");
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  for (const Scan& scan : log.scans) {
    Pose T;
    if (!interpolate_poses(log.poses, scan.time_s, log.pose_accuracy.max_gap_s, T)) continue;
    scans.push_back(scan);
    poses.push_back(T);
  }
  if (scans.empty())
    return scans_lack(log, "no scan has a measured pose",
                      "poses.tum with headings, at the times of the scans");
  LineMap map = build_line_map(scans, poses, options);
  if (map.lines.empty())
    return scans_lack(log, "the scans show no straight wall twice", "scans of a building");
  return map;
}

Result<void> line_map_fits(const LineMap& map, const MeasurementLog& log) {
  if (map.lines.empty())
    return scans_lack(log, "the map has no lines", "a map built from scans at known poses");
  if (log.scans.empty()) return scans_lack(log, "the run has no scans", "scans.csv");
  if (log.odometry.empty()) return scans_lack(log, "the run has no odometry", "odometry.csv");
  if (log.poses.empty())
    return scans_lack(log, "nothing says where the run starts", "a measured pose in poses.tum");
  return {};
}

}  // namespace octant
