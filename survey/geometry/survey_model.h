// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/scene.h"
#include "models/site.h"

namespace octant::survey {

inline constexpr std::size_t kAllRound = static_cast<std::size_t>(-1);  ///< in place of a pattern

struct SurveyBeacon {
  std::string name;
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< unit vector, map; zero: all round
  std::size_t pattern = kAllRound;                 ///< index into SurveyModel::patterns
};

struct SurveyReceiver {
  std::string name;
  Eigen::Vector3d p_vehicle_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< unit vector, vehicle frame; zero: all round
  std::size_t pattern = kAllRound;
};

/// An upright piece of wall that stops sound.
struct WallPiece {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero(), to_m = Eigen::Vector2d::Zero();
  double bottom_m = 0.0, top_m = std::numeric_limits<double>::infinity();
};

/// A(d) = A_1m / d exp(-alpha d) times both gains, against the threshold; and never beyond range_m.
struct Hearing {
  double amplitude_1m_v = 0.0,
         threshold_v = 0.0;  ///< threshold 0: received up to range_m wherever both gains are above zero
  double absorption_np_per_m = 0.0;
  double range_m = std::numeric_limits<double>::infinity();
};

/// Variance of one range: sigma^2 = constant^2 + per_m^2 d^2 + per_sqrt_m^2 d.
struct RangeNoise {
  double constant_m = 0.0, per_m = 0.0, per_sqrt_m = 0.0;
  [[nodiscard]] bool grows() const { return per_m != 0.0 || per_sqrt_m != 0.0; }
  [[nodiscard]] double variance_m2(double distance_m) const {
    return constant_m * constant_m + per_m * per_m * distance_m * distance_m +
           per_sqrt_m * per_sqrt_m * distance_m;
  }
};

/// Unknowns of a fix, in this order: x, y, z (spatial motion), rotation (heading, or three in the vehicle's
/// frame), the clock's offset in metres. Rotations are unknowns if the receivers can determine them: two
/// separate receivers in planar motion, three that span a plane in spatial motion. Otherwise a fix is the
/// position of the receivers.
struct Unknowns {
  int position = 2;  ///< 2 or 3
  int rotation = 0;  ///< 0, 1 (planar) or 3 (spatial)
  bool clock = false;
  [[nodiscard]] int count() const { return position + rotation + (clock ? 1 : 0); }
  /// Size of the packed upper triangle of a symmetric matrix, row by row.
  [[nodiscard]] int entries() const { return count() * (count() + 1) / 2; }
};

/// Everything that determines the quality of a geometry, as one plain value; changing a beacon in it changes
/// the geometry.
struct SurveyModel {
  std::string name;
  Motion motion = Motion::kPlanar;
  Clock clock = Clock::kSynchronised;
  std::size_t vehicle = 0;  ///< index in the site or deployment
  Unknowns unknowns;
  std::vector<SurveyBeacon> beacons;      ///< beacons with a position
  std::vector<SurveyReceiver> receivers;  ///< receivers of the vehicle
  std::vector<BeamPattern> patterns;
  std::vector<WallPiece> walls;
  std::vector<Eigen::Vector2d>
      floor_m;  ///< the scene's, else the calibrated area, else the beacons' hull; never empty
  Hearing hearing;
  RangeNoise noise;
  Medium medium;
  double speed_mps = 343.0;
  double speed_sigma_mps = 0.0;
  double vehicle_z_m = 0.0;
  Tolerance tolerance;
  std::vector<std::string> warnings;
};

/// The unknowns that receivers at these places allow.
[[nodiscard]] Unknowns unknowns_of(Motion motion, Clock clock, const std::vector<SurveyReceiver>& receivers);

/// Distance at which a pulse on both axes falls below the threshold, at most range_m.
[[nodiscard]] double reach_m(const Hearing& hearing);

}  // namespace octant::survey
