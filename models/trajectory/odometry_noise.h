// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
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
  const double chord_m = std::hypot(step.dx_m, step.dy_m, step.dz_m), d = std::max(chord_m, step.way_m),
               turn = std::hypot(step.dheading_rad, step.turn_x_rad, step.turn_y_rad);
  OdometryVariance v = {square(a.distance_sigma_m_per_sqrt_m) * d + square(a.floor_m),
                        square(a.heading_sigma_rad_per_sqrt_m) * d + square(a.heading_sigma_per_rad * turn) +
                            square(a.floor_rad)};
  // A turn that goes wrong along a long way moves its end across by what was still to go.
  if (step.way_m > 0) v.distance_m2 += v.heading_rad2 * square(chord_m) / 3;
  return v;
}

}  // namespace octant
