// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace octant {

/// How strongly a transducer sounds or hears by the angle off its axis: a gain of the amplitude, 1 on the
/// axis.
struct BeamPattern {
  enum class Kind {
    kCone,         ///< 1 up to half_angle_rad, 0 beyond
    kCosinePower,  ///< cos(angle)^exponent up to half_angle_rad (at most a right angle), 0 beyond
    kHalfPower,    ///< log_directivity() of attenuation.h up to half_angle_rad, 0 beyond
    kTable         ///< linear between (angle_rad, gain), 0 beyond the last angle
  };
  std::string name;
  Kind kind = Kind::kCone;
  double half_angle_rad = 3.2;  ///< pi or more: all round
  double exponent = 1.0;
  double half_power_angle_rad = 1.0;    ///< off the axis, 3 dB down
  std::vector<double> angle_rad, gain;  ///< angles rise from 0
  int line = 0;                         ///< in its file
};
/// Gain at a cosine of the angle off the axis.
[[nodiscard]] double beam_gain(const BeamPattern& pattern, double cosine);

/// What stops sound, and vehicles where it is closed: a wall, a rack, a column.
struct SceneWall {
  std::string name;
  std::vector<Eigen::Vector2d> points_m;  ///< corners in order
  bool solid = false;  ///< a closed polygon with nothing but material within; else a polyline
  double bottom_m = 0.0, top_m = std::numeric_limits<double>::infinity();
  bool blocks_sound = true, blocks_vehicle = true;  ///< a vehicle: where it is solid
  double slack_m = 0.0;  ///< how deep a beacon may stand in it: half a pixel of an imported map
  int line = 0;
};

/// Where a beacon may be mounted.
struct SceneMount {
  enum class Kind {
    kWall,     ///< along a polyline, at heights from low_m to high_m
    kCeiling,  ///< within a polygon, at heights from low_m to high_m
    kPole      ///< at one point, at heights from low_m to high_m
  };
  std::string name;
  Kind kind = Kind::kWall;
  std::vector<Eigen::Vector2d> points_m;
  double low_m = 0.0, high_m = 0.0;
  /// Of what is mounted there. Without: a wall's beacons look to the left of its polyline, a ceiling's down,
  /// a pole's all round.
  std::optional<Eigen::Vector3d> axis;
  int line = 0;
};

/// What the scene adds to a beacon of the site.
struct SceneBeacon {
  std::string name;
  std::optional<Eigen::Vector3d> axis;  ///< unit vector, map
  std::optional<std::size_t> pattern;   ///< index into Scene::patterns; none: Scene::beacon_pattern
  int line = 0;
};

struct SceneRoute {
  std::string name;
  std::vector<Eigen::Vector2d> points_m;
  int line = 0;
};

/// How far the signal carries.
struct SceneAcoustics {
  std::optional<double> frequency_hz;         ///< with it the absorption is ISO 9613-1's in the site's medium
  std::optional<double> absorption_np_per_m;  ///< stated; goes before the standard's
  std::optional<double> amplitude_1m_v,
      threshold_v;                ///< none: those of the site's attenuation; none there: heard up to range_m
  std::optional<double> range_m;  ///< never heard beyond
};

/// What a range's standard deviation grows by with the distance: sigma^2 = (c noise.tof_sigma_s)^2 + a^2 d^2
/// + b^2 d.
struct SceneNoise {
  double sigma_m_per_m = 0.0;       ///< a: gradients of temperature, wind
  double sigma_m_per_sqrt_m = 0.0;  ///< b: turbulence along the path
};

/// A place as plans show it: what stands where, who may drive where, and how far one hears.
struct Scene {
  std::string path;                      ///< of the file, empty if made in memory
  std::vector<Eigen::Vector2d> floor_m;  ///< outline; empty: taken from the beacons
  int floor_line = 0;
  std::vector<SceneWall> walls;
  std::vector<SceneMount> mounts;
  std::vector<SceneRoute> routes;
  std::vector<BeamPattern> patterns;
  std::vector<SceneBeacon> beacons;
  std::optional<std::size_t> beacon_pattern,
      receiver_pattern;  ///< of all beacons and receivers with an axis; none: all round
  SceneAcoustics acoustics;
  SceneNoise noise;
  double cell_m = 0.25;
  int cell_line = 0;
  int headings = 1;                     ///< looked at in each cell, evenly from heading 0; the worst counts
  double vehicle_z_m = 0.0;             ///< of the vehicle's frame, spatial motion only
  double temperature_error_degC = 5.0;  ///< what-if: the air is warmer by this and nobody says so
  int coverage = 0;  ///< beacons that a cell should hear; 0: as many as the pose has unknowns, and one
  std::vector<std::string> imported;  ///< files that the scene was read from beside its own
  std::vector<std::string> warnings;
};

}  // namespace octant
