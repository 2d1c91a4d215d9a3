// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "models/run.h"

namespace octant {

/// Clock of the counter card that Thamma describes. One period is 50 ns (the paper prints 5 ns for it).
inline constexpr double kCounterClock_hz = 20e6;

/// Thamma eq. 1: T = C / 20 MHz [s].
[[nodiscard]] inline double counter_time_s(std::uint64_t counts, double clock_hz = kCounterClock_hz) {
  return static_cast<double>(counts) / clock_hz;
}

/// Raw value of the counter card: clock periods from the firing of a beacon to its pulse at a receiver.
struct CounterReading {
  double time_s = 0.0;
  BeaconId beacon;
  ReceiverId receiver{0};
  std::int64_t epoch = kNoEpoch;
  std::uint64_t counts = 0;
  int line = 0;  ///< line in the log
};

/// Mean of the values that agree, and the interval that contains them.
struct AgreeingMean {
  double mean = 0.0;
  double low = 0.0, high = 0.0;  ///< inclusive bounds; values outside are outliers
  std::size_t agreeing = 0;
};

/// Thamma eq. 2, Ta = (T1 + T2 + T3 + T4) / 4, generalised to any number of values and with rejection of
/// outliers. The largest group of values within `spread` of each other is averaged. Among groups of equal
/// size the earliest is used, because an echo is late.
/// @param values finite, at least one, in any order  @param spread >= 0, in the unit of the values
[[nodiscard]] inline AgreeingMean mean_of_agreeing(std::span<const double> values, double spread) {
  AgreeingMean best;
  for (const double low : values) {
    AgreeingMean group{.low = low, .high = low};
    double sum = 0.0;  // sum of the differences from `low`, which keeps small numbers exact
    for (const double value : values) {
      if (value < low || value > low + spread) continue;
      sum += value - low;
      group.high = std::max(group.high, value);
      ++group.agreeing;
    }
    group.mean = low + sum / static_cast<double>(group.agreeing);
    if (group.agreeing > best.agreeing || (group.agreeing == best.agreeing && group.low < best.low))
      best = group;
  }
  return best;
}

/// Arrivals of a counter log. The values of a beacon at a receiver in one epoch (or at one time without
/// epochs), four in the paper, are combined into one arrival by eq. 1 and 2, without outliers. Arrivals are
/// in the order of their first values.
/// @param spread_s  largest difference between values that agree
[[nodiscard]] std::vector<Arrival> arrivals_of_counters(std::span<const CounterReading> readings,
                                                        double spread_s, double clock_hz = kCounterClock_hz);

}  // namespace octant
