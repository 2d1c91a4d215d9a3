// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "survey/map/binned_map.h"

namespace octant::survey {

struct MapDrawing {
  double width_px = 640.0;
  bool beacon_names = true;
};

/// A map as a self-contained SVG element: bins, floor, walls, beacons, routes, axes in metres and a scale of
/// colours with the title and unit. All text is <text>; names are escaped.
[[nodiscard]] std::string map_svg(const Survey& survey, const BinnedMap& map, const MapDrawing& drawing = {});

/// A value with its unit as people read it: millimetres for short lengths, "3.2 m", "1.4".
[[nodiscard]] std::string figure_text(double value, const std::string& unit);

}  // namespace octant::survey
