// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include <Eigen/Core>

namespace octant::calib {

/// An error that many observations have in common and that no parameter takes up.
struct CommonError {
  enum class Kind {
    kWay,    ///< odometry's is too long by that part of it
    kTurns,  ///< likewise too large
    kSpeed,  ///< sound is faster by that part of it at the recording's end than at its beginning
    kDrift,  ///< times of flight are longer by that [s] at its end
    kJump,   ///< times of flight are longer by that [s] from a time on
    kShift,  ///< measured poses are shifted by that [m] from a time on
    kLag     ///< measured poses are stamped late by that [s]
  };
  Kind kind = Kind::kWay;
  std::size_t run = 0;    ///< index into Problem::runs; all odometry has one error
  double time_s = 0.0;    ///< of a jump or a shift
  double size = 0.0;      ///< about
  double sigmas = 0.0;    ///< size over its standard deviation
  double length_m = 0.0;  ///< by which it moves ranges or poses, about
  /// Noise over the stated one that is left without it and without all else that was found; infinite: not
  /// adjusted, or many arrivals are left out.
  double noise_left = INFINITY;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< unit vector of a shift, in the map
};

[[nodiscard]] inline bool is_of_odometry(const CommonError& error) {
  return error.kind == CommonError::Kind::kWay || error.kind == CommonError::Kind::kTurns;
}

}  // namespace octant::calib
