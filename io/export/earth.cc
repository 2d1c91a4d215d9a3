// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/export/earth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr double kEarthDegree_rad = std::numbers::pi / 180;
constexpr double kEquator_m = 6378137.0, kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

/// Radius of curvature across the meridian.
double across_m(double sin_latitude) {
  return kEquator_m / std::sqrt(1 - kEccentricity2 * sin_latitude * sin_latitude);
}

}  // namespace

EarthPlace place_on_earth(const Eigen::Vector3d& p_map_m, const EarthOrigin& origin) {
  const double phi = origin.latitude_deg * kEarthDegree_rad, lambda = origin.longitude_deg * kEarthDegree_rad;
  const double s = std::sin(phi), c = std::cos(phi), N = across_m(s), h = origin.altitude_m;
  const double north = p_map_m.x() * std::cos(origin.north_rad) + p_map_m.y() * std::sin(origin.north_rad);
  const double east = p_map_m.x() * std::sin(origin.north_rad) - p_map_m.y() * std::cos(origin.north_rad);
  const double up = p_map_m.z();
  // Earth-centred, with the x axis through the origin's meridian: longitudes count from there.
  const double x = (N + h) * c - s * north + c * up, y = east,
               z = (N * (1 - kEccentricity2) + h) * s + c * north + s * up;
  const double p = std::hypot(x, y);
  // Latitude by fixed-point iteration: the error shrinks by a factor of 150 or more each time.
  double latitude = std::atan2(z, p * (1 - kEccentricity2)), height = 0.0;
  for (int i = 0; i < 8; ++i) {
    const double sine = std::sin(latitude), cosine = std::cos(latitude), n = across_m(sine);
    height = std::abs(cosine) > 0.1 ? p / cosine - n : z / sine - n * (1 - kEccentricity2);
    latitude = std::atan2(z, p * (1 - kEccentricity2 * n / (n + height)));
  }
  double longitude_deg = (lambda + std::atan2(y, x)) / kEarthDegree_rad;
  if (longitude_deg > 180) longitude_deg -= 360;
  if (longitude_deg <= -180) longitude_deg += 360;
  return {latitude / kEarthDegree_rad, longitude_deg, height};
}

Result<EarthOrigin> origin_from_words(std::string_view words, double north_deg) {
  double numbers[3] = {0.0, 0.0, 0.0};
  std::size_t count = 0;
  bool good = !words.empty();
  for (std::string_view left = words; good; ++count) {
    const std::size_t comma = left.find(',');
    good = count < 3 && parse_number(left.substr(0, comma), numbers[std::min<std::size_t>(count, 2)]) ==
                            NumberText::kNumber;
    if (comma == std::string_view::npos) break;
    left.remove_prefix(comma + 1);
  }
  good = good && count >= 1 && std::abs(numbers[0]) <= 90 && std::abs(numbers[1]) <= 180 &&
         std::isfinite(numbers[2]);
  if (!good)
    return fail({.code = Errc::kUsage,
                 .found = words.empty() ? "the position of the map on the earth is not stated"
                                        : "--origin " + in_quotes(words),
                 .expected =
                     "--origin LATITUDE,LONGITUDE[,ALTITUDE] of the map's origin, degrees and metres, as "
                     "in --origin 52.5186,13.4083"});
  return EarthOrigin{numbers[0], numbers[1], numbers[2], north_deg * kEarthDegree_rad};
}

}  // namespace octant::io
