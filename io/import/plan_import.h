// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "models/support/result.h"

namespace octant::io {

/// A line of a drawing, in metres.
struct DrawnLine {
  std::string layer;
  std::vector<Eigen::Vector2d> points_m;
  bool closed = false;
  int line = 0;  ///< in the file
};

struct Drawing {
  std::vector<DrawnLine> lines;
  std::vector<std::string> warnings;  ///< entities that are not read, units that are assumed
};

/// Lines of an ASCII DXF: LINE, LWPOLYLINE (bulges as chords of at most 10 degrees) and POLYLINE of the
/// ENTITIES section; other entities are counted in a warning. Lengths by $INSUNITS; @param unit_m  goes
/// before it.
[[nodiscard]] Result<Drawing> drawing_from_dxf(std::string_view text, const std::string& file,
                                               std::optional<double> unit_m = {});
[[nodiscard]] Result<Drawing> read_dxf(const std::string& path, std::optional<double> unit_m = {});

/// A map of ROS' map_server: occupancy by cell, row 0 the lowest.
struct RosMap {
  enum Cell : std::uint8_t { kFree, kOccupied, kUnknown };
  std::size_t columns = 0, rows = 0;
  double resolution_m = 0.05;
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< position of the lower left corner
  double yaw_rad = 0.0;                                ///< direction of the columns
  std::vector<std::uint8_t> cells;                     ///< Cell, row by row
  std::string image;                                   ///< the PGM
  [[nodiscard]] Eigen::Vector2d place_m(double column, double row) const;
};

/// Its YAML file and the PGM (P5 or P2) that it names. Errors: anything that map_server would not read, more
/// than 1e8 cells.
[[nodiscard]] Result<RosMap> read_ros_map(const std::string& yaml_path);

/// Cells of a kind as rectangles that do not overlap: first columns, then rows as far as they go. Corners in
/// the map, counter-clockwise.
[[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> rectangles_of(const RosMap& map, RosMap::Cell kind);

/// A costmap for map_server: grey values 0 to 255, row 0 the lowest, and the YAML with its position.
struct CostmapText {
  std::string pgm, yaml;
};
[[nodiscard]] CostmapText costmap_text(const std::vector<std::uint8_t>& grey, std::size_t columns,
                                       std::size_t rows, double resolution_m, const Eigen::Vector2d& origin_m,
                                       const std::string& image_name);

}  // namespace octant::io
