// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace octant {

struct PulseTrainOptions {
  double sample_rate_hz = 2.0e6;  ///< of the FIFO: 0.5 us, 0.17 mm of sound
  double carrier_hz = 49.4e3;     ///< of the burst
  int min_edges = 4;              ///< fewer rising edges in a train are no burst
  int max_edges = 16;             ///< of each train, from its first on: echoes come behind
};

/// What two receivers heard of one burst. The difference is by phase, so it is finer than the first edges.
struct PulseTiming {
  bool ok = false;            ///< false: one of the trains holds no burst; nothing else is meaningful then
  double left_tof_s = 0.0;    ///< mean of the first edges less half the difference
  double right_tof_s = 0.0;   ///< and plus half
  double difference_s = 0.0;  ///< right less left: phase, its whole cycles by the first edges
  double difference_edges_s = 0.0;  ///< right less left, by the first edges alone
  double phase_rad = 0.0;           ///< right behind left, in (-pi, pi]
  int cycles = 0;                   ///< whole periods between the two
};

/// Times of flight to two receivers from their comparators' outputs (Shoval and Borenstein, figure 2): the
/// time of flight from the first edges, good over any distance, and the phase from the mean offset of the
/// edges, good to a fraction of a sample but only within one period; the first tells the cycle of the second.
/// Samples are 0 or not 0, one each 1 / sample_rate_hz from the firing on. An edge lies midway between its
/// two samples.
[[nodiscard]] PulseTiming time_pulse_trains(std::span<const std::uint8_t> left,
                                            std::span<const std::uint8_t> right,
                                            const PulseTrainOptions& options = {}) noexcept;

}  // namespace octant
