// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "models/run.h"

namespace octant {

/// Variances of an odometry row. The variance of a part of the row is proportional.
struct OdometryVariance {
  double distance_m2 = 0.0;   ///< along and across the direction of motion
  double heading_rad2 = 0.0;  ///< about each axis for spatial motion
};

/// Noise of OdometryAccuracy for the length and turn of a step.
[[nodiscard]] inline OdometryVariance variance_of(const OdometryStep& step, const OdometryAccuracy& a) {
  const auto square = [](double x) { return x * x; };
  const double chord_m = std::hypot(step.dx_m, step.dy_m, step.dz_m), d = std::max(chord_m, step.way_m),
               turn = std::hypot(step.dheading_rad, step.turn_x_rad, step.turn_y_rad);
  OdometryVariance v = {square(a.distance_sigma_m_per_sqrt_m) * d + square(a.floor_m),
                        square(a.heading_sigma_rad_per_sqrt_m) * d + square(a.heading_sigma_per_rad * turn) +
                            square(a.floor_rad)};
  // A heading error along a long row displaces its end sideways in proportion to the remaining distance.
  if (step.way_m > 0) v.distance_m2 += v.heading_rad2 * square(chord_m) / 3;
  return v;
}

/// Variances that an adjustment may weight with. The stated ones are zero for rows at rest without a floor.
[[nodiscard]] inline OdometryVariance estimation_variance_of(const OdometryStep& step,
                                                             const OdometryAccuracy& a) {
  constexpr double kLeast_m2 = 1e-12, kLeast_rad2 = 1e-12;
  const OdometryVariance v = variance_of(step, a);
  return {std::max(v.distance_m2, kLeast_m2), std::max(v.heading_rad2, kLeast_rad2)};
}

}  // namespace octant
