// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include <Eigen/Core>

namespace octant::calib {

/// An error that many observations have in common and that no parameter absorbs.
struct CommonError {
  enum class Kind {
    kWay,     ///< relative error of odometry distances
    kTurns,   ///< relative error of odometry turns
    kSpeed,   ///< relative increase of the speed from start to end of the recording
    kDrift,   ///< increase of the times of flight at its end [s]
    kJump,    ///< increase of the times of flight from a time on [s]
    kShift,   ///< shift of measured poses from a time on [m]
    kLag,     ///< lag of the time stamps of measured poses [s]
    kPattern  ///< increase of ranges in front of receivers, and decrease behind them, in all runs [m]
  };
  Kind kind = Kind::kWay;
  std::size_t run = 0;    ///< index into Problem::runs; errors of devices are those of all runs
  double time_s = 0.0;    ///< time of a jump or a shift
  double size = 0.0;      ///< approximate
  double sigmas = 0.0;    ///< size divided by its standard deviation
  double length_m = 0.0;  ///< approximate shift of ranges or poses
  /// Ratio of the noise that remains without all common errors to that of the site file; infinite: not
  /// adjusted, or many arrivals are rejected.
  double noise_left = INFINITY;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< unit vector of a shift, in the map
};

[[nodiscard]] inline bool is_of_odometry(const CommonError& error) {
  return error.kind == CommonError::Kind::kWay || error.kind == CommonError::Kind::kTurns;
}

/// Errors of a device, which all runs have in common.
[[nodiscard]] inline bool is_of_all_runs(const CommonError& error) {
  return is_of_odometry(error) || error.kind == CommonError::Kind::kPattern;
}

}  // namespace octant::calib
