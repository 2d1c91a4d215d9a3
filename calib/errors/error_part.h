// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant::calib {

/// Axis of a common part of errors: one value for each cell.
enum class ErrorAxis {
  kTime,       ///< intervals of time [s]
  kPlace,      ///< squares of the floor [m]
  kDirection,  ///< sectors of the direction to the beacon in the vehicle frame [rad]
  kAspect,     ///< sectors of the direction from the beacon, in the map [rad]
  kRange,      ///< intervals of the distance to the beacon [m]
  kConstant    ///< the whole log
};

/// Who shares a part of the errors.
enum class ErrorGroup {
  kPair,     ///< each beacon-receiver pair has its own
  kBeacon,   ///< all receivers of a beacon share it
  kReceiver  ///< all beacons of a receiver share it
};

/// A random part of the errors of arrivals (or bearings): one value for each group and cell.
struct ErrorPart {
  bool bearings = false;  ///< errors of bearings; otherwise of times of flight
  ErrorGroup group = ErrorGroup::kPair;
  ErrorAxis axis = ErrorAxis::kConstant;
  double extent = 0.0;    ///< size of a cell, in the unit of the axis
  double variance = 0.0;  ///< in units of the white noise of the adjustment
};

}  // namespace octant::calib
