// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "models/run.h"

namespace octant {

/// Variances of an odometry row; of a part of it, in proportion.
struct OdometryVariance {
  double distance_m2 = 0.0;   ///< the same along and across
  double heading_rad2 = 0.0;  ///< in space, about each axis
};

/// As `OdometryAccuracy` says for a step of that length and turn.
[[nodiscard]] inline OdometryVariance variance_of(const OdometryStep& step, const OdometryAccuracy& a) {
  const auto square = [](double x) { return x * x; };
  const double d = std::hypot(step.dx_m, step.dy_m, step.dz_m),
               turn = std::hypot(step.dheading_rad, step.turn_x_rad, step.turn_y_rad);
  return {square(a.distance_sigma_m_per_sqrt_m) * d + square(a.floor_m),
          square(a.heading_sigma_rad_per_sqrt_m) * d + square(a.heading_sigma_per_rad * turn) +
              square(a.floor_rad)};
}

}  // namespace octant
