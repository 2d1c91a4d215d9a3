// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "models/support/result.h"

namespace octant::io {

/// Position of the map's origin on the earth (WGS 84).
struct EarthOrigin {
  double latitude_deg = 0.0, longitude_deg = 0.0, altitude_m = 0.0;
  double north_rad = 0.0;  ///< direction of north in the map, counter-clockwise from +x; pi/2: y points north
};

struct EarthPlace {
  double latitude_deg = 0.0, longitude_deg = 0.0;
  double altitude_m = 0.0;  ///< above the ellipsoid, if the origin's is
};

/// Converts a point of the map to geodetic coordinates. The map is the plane that touches WGS 84 at its
/// origin (east, north, up), rotated by north_rad. The conversion uses earth-centred coordinates and is exact
/// to a micrometre within 100 km.
[[nodiscard]] EarthPlace place_on_earth(const Eigen::Vector3d& p_map_m, const EarthOrigin& origin);

/// "LATITUDE,LONGITUDE[,ALTITUDE]" in degrees and metres. Errors: kUsage.
[[nodiscard]] Result<EarthOrigin> origin_from_words(std::string_view words, double north_deg);

}  // namespace octant::io
