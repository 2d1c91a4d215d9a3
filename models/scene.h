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

/// Directional pattern of a transducer: gain of the amplitude by the angle off its axis, 1 on the axis.
struct BeamPattern {
  enum class Kind {
    kCone,         ///< 1 up to half_angle_rad, 0 beyond
    kCosinePower,  ///< cos(angle)^exponent up to half_angle_rad (at most a right angle), 0 beyond
    kHalfPower,    ///< log_directivity() of attenuation.h up to half_angle_rad, 0 beyond
    kTable         ///< linear between (angle_rad, gain), 0 beyond the last angle
  };
  std::string name;
  Kind kind = Kind::kCone;
  double half_angle_rad = 3.2;  ///< pi or more: omnidirectional
  double exponent = 1.0;
  double half_power_angle_rad = 1.0;    ///< angle off the axis at which the gain is down by 3 dB
  std::vector<double> angle_rad, gain;  ///< angles in ascending order, starting at 0
  int line = 0;                         ///< line in the scene file
};
/// Gain for a given cosine of the angle off the axis.
[[nodiscard]] double beam_gain(const BeamPattern& pattern, double cosine);

/// Obstacle for sound, and for vehicles if it is closed: a wall, a rack or a column.
struct SceneWall {
  std::string name;
  std::vector<Eigen::Vector2d> points_m;  ///< corners in order
  bool solid = false;                     ///< closed polygon filled with material; otherwise a polyline
  double bottom_m = 0.0, top_m = std::numeric_limits<double>::infinity();
  bool blocks_sound = true, blocks_vehicle = true;  ///< blocks_vehicle applies to solid obstacles only
  double slack_m = 0.0;  ///< depth up to which a beacon may lie inside it: half a pixel of an imported map
  int line = 0;
};

/// Surface on which beacons may be mounted.
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
  /// Axis of the beacons on this mount. By default beacons on a wall face the left side of its polyline,
  /// beacons on a ceiling face down, and beacons on a pole are omnidirectional.
  std::optional<Eigen::Vector3d> axis;
  int line = 0;
};

/// Properties that the scene adds to a beacon of the site.
struct SceneBeacon {
  std::string name;
  std::optional<Eigen::Vector3d> axis;  ///< unit vector in the map
  std::optional<std::size_t> pattern;   ///< index into Scene::patterns; default: Scene::beacon_pattern
  int line = 0;
};

struct SceneRoute {
  std::string name;
  std::vector<Eigen::Vector2d> points_m;
  int line = 0;
};

/// Reach of the signal.
struct SceneAcoustics {
  std::optional<double>
      frequency_hz;  ///< if given, the absorption follows from ISO 9613-1 for the medium of the site
  std::optional<double> absorption_np_per_m;  ///< if given, used instead of the standard's value
  std::optional<double> amplitude_1m_v,
      threshold_v;  ///< default: the attenuation of the site; without one everything within range_m is
                    ///< received
  std::optional<double> range_m;  ///< maximum reach
};

/// Growth of a range's standard deviation with distance: sigma^2 = (c noise.tof_sigma_s)^2 + a^2 d^2 + b^2 d.
struct SceneNoise {
  double sigma_m_per_m = 0.0;       ///< coefficient a: gradients of temperature, wind
  double sigma_m_per_sqrt_m = 0.0;  ///< coefficient b: turbulence along the path
};

/// Floor plan of a place: obstacles, mounts, routes and acoustics.
struct Scene {
  std::string path;                      ///< path of the file; empty for a scene that was made in memory
  std::vector<Eigen::Vector2d> floor_m;  ///< outline; if empty, it follows from the beacons
  int floor_line = 0;
  std::vector<SceneWall> walls;
  std::vector<SceneMount> mounts;
  std::vector<SceneRoute> routes;
  std::vector<BeamPattern> patterns;
  std::vector<SceneBeacon> beacons;
  std::optional<std::size_t> beacon_pattern,
      receiver_pattern;  ///< default pattern of beacons and receivers that have an axis; without one they are
                         ///< omnidirectional
  SceneAcoustics acoustics;
  SceneNoise noise;
  double cell_m = 0.25;
  int cell_line = 0;
  int headings =
      1;  ///< number of headings evaluated in each cell, evenly spaced from 0; the worst one counts
  double vehicle_z_m = 0.0;  ///< height of the vehicle's frame, spatial motion only
  double temperature_error_degC =
      5.0;  ///< assumed error of the stated air temperature, for the what-if analysis
  int coverage =
      0;  ///< number of beacons that each cell should receive; 0: number of unknowns of the pose plus one
  std::vector<std::string> imported;  ///< other files that the scene was read from
  std::vector<std::string> warnings;
};

}  // namespace octant
