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

/// A reading of the counter card: clock periods from the firing of a beacon to its pulse at a receiver.
struct CounterReading {
  double time_s = 0.0;
  BeaconId beacon;
  ReceiverId receiver{0};
  std::int64_t epoch = kNoEpoch;
  std::uint64_t counts = 0;
  int line = 0;  ///< of the log
};

/// Mean of the values that agree, and the window in which they lie.
struct AgreeingMean {
  double mean = 0.0;
  double low = 0.0, high = 0.0;  ///< both inclusive; values outside are the odd ones out
  std::size_t agreeing = 0;
};

/// Thamma eq. 2, Ta = (T1 + T2 + T3 + T4) / 4, of any number of values, without the odd one out: the largest
/// group of values within `spread` of each other is averaged; of groups equally large the earliest, because
/// an echo is late.
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
    if (group.agreeing > best.agreeing || (group.agreeing == best.agreeing && group.low < best.low))
      best = group;
  }
  return best;
}

/// Arrivals of a counter log: the readings of a beacon at a receiver in one epoch (without epochs: at one
/// time), four in the paper, become one arrival by eq. 1 and 2 without the odd one out, in the order of their
/// first readings.
/// @param spread_s  within which readings agree
[[nodiscard]] std::vector<Arrival> arrivals_of_counters(std::span<const CounterReading> readings,
                                                        double spread_s, double clock_hz = kCounterClock_hz);

}  // namespace octant
