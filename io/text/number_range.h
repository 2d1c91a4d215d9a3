// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/.

#include <limits>

#include "models/site.h"

namespace octant::io {

/// Values a number may take; `words` names them in messages ("a positive number").
struct NumberRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false;
  const char* words = "a number";
  [[nodiscard]] constexpr bool contains(double value) const {
    return value >= low && value <= high && !(low_excluded && value == low);
  }
};
inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kPositive{.low = 0.0, .low_excluded = true, .words = "a positive number"};
inline constexpr NumberRange kNotNegative{.low = 0.0, .words = "zero or a positive number"};
inline constexpr NumberRange kFraction{.low = 0.0, .high = 1.0, .words = "a fraction from 0 to 1"};
inline constexpr NumberRange kHalfPowerAngle{
    .low = kLeastHalfPowerAngle_rad,
    .high = kMostHalfPowerAngle_rad,
    .words = "an angle off the axis from 0.02 to 2.8 rad (half of the beam width at -3 dB)"};
inline constexpr NumberRange kCelsius{
    .low = -100.0, .high = 100.0, .words = "degrees Celsius from -100 to 100 (20 degC are 293 K)"};
inline constexpr NumberRange kRelativeHumidity{
    .low = 0.0, .high = 1.0, .words = "a fraction from 0 to 1 (50 % is 0.5)"};
inline constexpr NumberRange kPascals{
    .low = 1.0e4, .high = 1.0e7, .words = "pascals, such as 101325 (1013 hPa are 101300)"};

}  // namespace octant::io
