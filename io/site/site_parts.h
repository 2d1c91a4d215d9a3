// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: what the readers of a site file's blocks share.

#include <array>
#include <optional>
#include <string>
#include <unordered_map>

#include "io/yaml/yaml_reader.h"
#include "models/run.h"

namespace octant::io {

/// Ids of one kind; a second use of one is an error that names both lines.
class UniqueIds {
 public:
  UniqueIds(const char* kind, YamlLog& log) : kind_(kind), log_(log) {}
  /// The `id` of an entry. Errors: missing, not a name, used before.
  /// @param otherwise  the id of an entry without one; empty: the id is required
  std::string take(YamlMap& map, const std::string& otherwise = "");

 private:
  const char* kind_;
  YamlLog& log_;
  std::unordered_map<std::string, int> lines_;
};

using Coordinates = std::array<std::optional<double>, 3>;

/// [x, y, z], each a number or null.
[[nodiscard]] Coordinates read_coordinates(const YamlNode& node, const std::string& name, NumberRange range,
                                           YamlLog& log);
/// A number for all three axes, or [sx, sy, sz].
[[nodiscard]] Coordinates read_sigmas(const YamlNode& node, const std::string& name, YamlLog& log);

/// `axis`, a direction of any length above zero; no value if the key is missing.
/// @param example  shown in the message about a vector of zero length
[[nodiscard]] std::optional<Eigen::Vector3d> read_axis(YamlMap& map, const char* example, YamlLog& log);

/// `beacons`; Site::timing has been read.
void read_beacons(YamlMap& root, Site& site, YamlLog& log);
/// `vehicles`, with their receivers, arrays, rails and ways to move.
void read_vehicles(YamlMap& root, Site& site, YamlLog& log);

}  // namespace octant::io
