// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace octant {

/// Clock of the counter card that Thamma describes. One period is 50 ns (the paper prints 5 ns for it).
inline constexpr double kCounterClock_hz = 20e6;

/// Thamma eq. 1: T = C / 20 MHz [s].
[[nodiscard]] inline double counter_time_s(std::uint64_t counts, double clock_hz = kCounterClock_hz) {
  return static_cast<double>(counts) / clock_hz;
}

/// Mean of the values that agree, and the window in which they lie.
struct AgreeingMean {
  double mean = 0.0;
  double low = 0.0, high = 0.0;  ///< both inclusive; values outside are the odd ones out
  std::size_t agreeing = 0;
};

/// Thamma eq. 2, Ta = (T1 + T2 + T3 + T4) / 4, of any number of values, without the odd one out: the largest group of values
/// within `spread` of each other is averaged; of groups equally large the earliest, because an echo is late.
/// @param values finite, at least one, any order  @param spread >= 0, unit of the values
[[nodiscard]] inline AgreeingMean mean_of_agreeing(std::span<const double> values, double spread) {
  AgreeingMean best;
  for (const double low : values) {
    AgreeingMean group{.low = low, .high = low};
    double sum = 0.0;  // of what lies above `low`: small numbers lose nothing
    for (const double value : values) {
      if (value < low || value > low + spread) continue;
      sum += value - low;
      group.high = std::max(group.high, value);
      ++group.agreeing;
    }
    group.mean = low + sum / static_cast<double>(group.agreeing);
    if (group.agreeing > best.agreeing || (group.agreeing == best.agreeing && group.low < best.low)) best = group;
  }
  return best;
}

}  // namespace octant
