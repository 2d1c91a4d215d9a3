// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace octant {

/// Speed of sound by height, linear between its levels and constant beyond the first and the last.
///
/// Sound in the sea is refracted, because its speed changes by several per cent with depth. The travel time
/// of the direct ray follows from Snell's law, cos(theta) / c = p: in a layer of height h in which the speed
/// changes from c1 to c2, with s = sqrt(1 - p^2 c^2),
///   x = p h (c1 + c2) / (s1 + s2),   t = h / (c2 - c1) ln(c2 (1 + s1) / (c1 (1 + s2)))
/// (Officer 1958, Introduction to the Theory of Sound Transmission, section 2-4; the first rearranged, so
/// that it holds for c1 = c2 too).
class SpeedProfile {
 public:
  struct Level {
    double height_m = 0.0;  ///< in the map, upwards: minus the depth
    double speed_mps = 0.0;
  };

  /// @param levels  one or more, heights strictly increasing, speeds positive
  explicit SpeedProfile(std::vector<Level> levels);

  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  [[nodiscard]] double speed_at(double height_m) const;
  /// Harmonic mean of the speed between two heights, the speed of a straight ray. At equal heights the speed
  /// there.
  [[nodiscard]] double mean_speed_mps(double from_height_m, double to_height_m) const;
  /// Travel time of the direct ray over a horizontal distance between two heights [s]. Where the direct ray
  /// would turn before it arrives (nearly horizontal paths) that of the straight ray.
  [[nodiscard]] double travel_time_s(double horizontal_m, double from_height_m, double to_height_m) const;
  /// Speed that gives the travel time of the ray over the distance of two points of the map. Map coordinates
  /// belong to the sea surface (z = 0): at depth, horizontal distances are shorter by z / R (R: radius of the
  /// earth), 0.3 m in 1.4 km at a mean depth of 1.35 km.
  [[nodiscard]] double effective_speed_mps(const Eigen::Vector3d& from_map_m,
                                           const Eigen::Vector3d& to_map_m) const;

 private:
  /// Levels of the path between two heights, both ends included.
  [[nodiscard]] std::vector<Level> layers(double from_height_m, double to_height_m) const;

  std::vector<Level> levels_;
};

/// Speed of sound in sea water (Mackenzie, J. Acoust. Soc. Am. 70 (1981) 807; stated standard error 0.07 m/s
/// for 2 to 30 degC, salinities 25 to 40, depths to 8 km). Check: 25 degC, 35, 1000 m: 1550.744 m/s.
/// @param salinity  parts per thousand
[[nodiscard]] double sea_water_speed_mps(double temperature_degC, double salinity, double depth_m);

}  // namespace octant
