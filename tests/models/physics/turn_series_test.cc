// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/turn_series.h"

#include <vector>

#include <gtest/gtest.h>

namespace octant::test {
namespace turn_series_test {

/// Angles from zero to nearly half a turn, denser where the series end.
std::vector<double> angles() {
  std::vector<double> out;
  for (double a = 1e-6; a < 3.1; a *= 1.3) out.push_back(a);
  for (const double a : {0.2499999, 0.25, 0.2500001}) out.push_back(a);
  return out;
}

/// 1 - cos a and a - sin a without cancellation: 2 sin^2(a / 2), and the whole series of the sine.
long double lag_of(long double a) {
  long double term = a * a * a / 6, sum = 0;
  for (int k = 4; k < 60; k += 2) {
    sum += term;
    term *= -a * a / (static_cast<long double>(k) * (k + 1));
  }
  return sum;
}

TEST(TurnSeries, AreTheirClosedForms) {
  for (const double angle : angles()) {
    const long double a = angle, half = std::sin(a / 2);
    const double a2 = angle * angle, rounding = angle < 0.25 ? 4e-16 : 1e-13;  // which differences lose
    EXPECT_NEAR(versine_by_square(a2), static_cast<double>(2 * half * half / (a * a)), rounding) << angle;
    EXPECT_NEAR(sine_lag_by_cube(a2), static_cast<double>(lag_of(a) / (a * a * a)), rounding) << angle;
    // 1 / a^2 - cos(a / 2) / (2 a sin(a / 2)) = (2 sin(a/2) - a cos(a/2)) / (2 a^2 sin(a/2)), and of h = a /
    // 2 sin h - h cos h = h (1 - cos h) - (h - sin h).
    const long double h = a / 2, q = std::sin(h / 2);
    EXPECT_NEAR(inverse_curvature(a2),
                static_cast<double>((h * 2 * q * q - lag_of(h)) / (a * a * std::sin(h))), rounding)
        << angle;
  }
}

TEST(TurnSeries, OfNoTurnAreTheirFirstTerms) {
  EXPECT_EQ(versine_by_square(0.0), 1.0 / 2);
  EXPECT_EQ(sine_lag_by_cube(0.0), 1.0 / 6);
  EXPECT_EQ(inverse_curvature(0.0), 1.0 / 12);
}

}  // namespace turn_series_test
}  // namespace octant::test
