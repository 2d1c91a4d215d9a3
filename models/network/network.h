// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
/// Survey network: points and observations of total stations, levels and tapes.
///
/// Horizontal angles turn from +x towards +y: counter-clockwise in a right-handed plane, clockwise if x is
/// north and y is east. A reader converts its file's convention to this one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace octant {

/// Role of one coordinate in the adjustment.
enum class CoordinateRole {
  kAbsent,  ///< not in the network (heights of a plane network)
  kFixed,   ///< known, not adjusted
  kFree,    ///< adjusted
  kDatum,   ///< adjusted, and defines the datum of a free network (inner constraints)
};

struct NetworkPoint {
  std::string id;
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();  ///< approximate, or exact where fixed
  std::array<CoordinateRole, 3> role{CoordinateRole::kAbsent, CoordinateRole::kAbsent,
                                     CoordinateRole::kAbsent};
  std::array<bool, 3> known{true, true, true};  ///< p_map_m has at least an approximate value
};

enum class SurveyKind {
  kDirection,           ///< [rad] with the orientation unknown of its set
  kAzimuth,             ///< [rad] from +x towards +y
  kAngle,               ///< [rad] at `from`, from `to` to `second`
  kZenithAngle,         ///< [rad] from +z, between instrument and target
  kHorizontalDistance,  ///< [m]
  kSlopeDistance,       ///< [m] between instrument and target
  kHeightDifference,    ///< [m] `to` less `from`
  kX,                   ///< [m] coordinate of `from`
  kY,                   ///< [m] coordinate of `from`
  kZ,                   ///< [m] coordinate of `from`
  kDx,                  ///< [m] coordinate difference, `to` less `from`
  kDy,                  ///< [m] coordinate difference, `to` less `from`
  kDz,                  ///< [m] coordinate difference, `to` less `from`
  kConstant,            ///< [m] additive constant of distances, as a prior; no points
};

struct SurveyObservation {
  SurveyKind kind = SurveyKind::kHorizontalDistance;
  int from = -1, to = -1, second = -1;  ///< indices of points
  int line = 0;                         ///< line in the file; 0: not from a file
  int set = -1;                         ///< orientation unknown of a direction
  int scale = -1, constant = -1;        ///< scale and additive constant of a distance; -1: none
  int target_constant = -1;             ///< additive constant of the device at `to`; -1: none
  double value = 0.0;                   ///< [rad] or [m]
  double sigma = 1.0;                   ///< [rad] or [m]; ignored within a covariance block
  double instrument_height_m = 0.0, target_height_m = 0.0;
};

/// Correlated observations: `covariance` of the observations first, first + 1, ...
struct ObservationCovariance {
  int first = 0;
  Eigen::MatrixXd covariance;
};

struct Network {
  std::vector<NetworkPoint> points;
  std::vector<SurveyObservation> observations;
  std::vector<ObservationCovariance> covariances;
  int sets = 0, scales = 0, constants = 0;
};

}  // namespace octant
