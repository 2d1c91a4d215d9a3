// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace octant {

/// Bound on small rotations, such as those between two rows of odometry. States in space are linearised at
/// them millions of times. The series need no trigonometric functions and avoid cancellation.
inline constexpr double kSmallTurn2 =
    0.0625;  ///< square of the angle; the first neglected term is below 1e-16

/// Evaluates a polynomial in x, lowest power first.
template <class... Rest>
[[nodiscard]] double polynomial(double x, double first, Rest... rest) {
  if constexpr (sizeof...(rest) == 0) {
    return first;
  } else {
    return first + x * polynomial(x, rest...);
  }
}

/// Coefficients of the rotation by a vector phi of length a, with K = [phi]x, as functions of a^2:
///   Exp(phi) = I + (1 - a^2 lag) K + versine K^2
///   Jr(phi) = I - versine K + lag K^2,   Jr^-1(phi) = I + K / 2 + curvature K^2
/// Returns the versine, (1 - cos a) / a^2.
[[nodiscard]] inline double versine_by_square(double a2) {
  if (a2 < kSmallTurn2)
    return polynomial(a2, 1.0 / 2, -1.0 / 24, 1.0 / 720, -1.0 / 40320, 1.0 / 3628800, -1.0 / 479001600,
                      1.0 / 87178291200.0);
  return (1 - std::cos(std::sqrt(a2))) / a2;
}
/// Returns the lag, (a - sin a) / a^3.
[[nodiscard]] inline double sine_lag_by_cube(double a2) {
  if (a2 < kSmallTurn2)
    return polynomial(a2, 1.0 / 6, -1.0 / 120, 1.0 / 5040, -1.0 / 362880, 1.0 / 39916800,
                      -1.0 / 6227020800.0);
  const double a = std::sqrt(a2);
  return (a - std::sin(a)) / (a2 * a);
}
/// Returns the curvature, 1 / a^2 - 1 / (2 a tan(a / 2)).
[[nodiscard]] inline double inverse_curvature(double a2) {
  if (a2 < kSmallTurn2)
    return polynomial(a2, 1.0 / 12, 1.0 / 720, 1.0 / 30240, 1.0 / 1209600, 1.0 / 47900160,
                      691.0 / 1307674368000.0, 1.0 / 74724249600.0);
  const double a = std::sqrt(a2);
  // (1 + cos a) / sin a, written as 1 / tan(a / 2) to keep its digits near half a turn.
  return 1 / a2 - 1 / (2 * a * std::tan(a / 2));
}

}  // namespace octant
