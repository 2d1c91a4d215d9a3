// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/head_tail/pulse_trains.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "models/physics/pose.h"

namespace octant {
namespace {

/// First rising edge of a train and the mean phase of its edges within the carrier's period. The mean is
/// taken on the circle: an edge that the comparator missed leaves it where it was.
struct Edges {
  int count = 0;
  double first_s = 0.0;
  double phase_rad = 0.0;
};

Edges rising_edges(std::span<const std::uint8_t> train, const PulseTrainOptions& options) {
  Edges edges;
  double cosine = 0.0, sine = 0.0;
  for (std::size_t i = 1; i < train.size() && edges.count < options.max_edges; ++i) {
    if (train[i - 1] != 0 || train[i] == 0) continue;
    const double edge_s = (static_cast<double>(i) - 0.5) / options.sample_rate_hz;
    if (edges.count++ == 0) edges.first_s = edge_s;
    const double phase = 2 * std::numbers::pi * options.carrier_hz * (edge_s - edges.first_s);
    cosine += std::cos(phase);
    sine += std::sin(phase);
  }
  // Relative to the first edge until here, which keeps the angles small and so exact.
  const double first = std::remainder(options.carrier_hz * edges.first_s, 1.0) * 2 * std::numbers::pi;
  edges.phase_rad = wrap_angle(first + std::atan2(sine, cosine));
  return edges;
}

}  // namespace

PulseTiming time_pulse_trains(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                              const PulseTrainOptions& options) noexcept {
  PulseTiming timing;
  const Edges l = rising_edges(left, options), r = rising_edges(right, options);
  if (l.count < options.min_edges || r.count < options.min_edges) return timing;
  timing.ok = true;
  timing.difference_edges_s = r.first_s - l.first_s;
  timing.phase_rad = wrap_angle(r.phase_rad - l.phase_rad);
  const double by_phase = timing.phase_rad / (2 * std::numbers::pi);  // periods, within half of one
  timing.cycles = static_cast<int>(std::lround(timing.difference_edges_s * options.carrier_hz - by_phase));
  timing.difference_s = (by_phase + timing.cycles) / options.carrier_hz;
  const double mean_s = (l.first_s + r.first_s) / 2;
  timing.left_tof_s = mean_s - timing.difference_s / 2;
  timing.right_tof_s = mean_s + timing.difference_s / 2;
  return timing;
}

}  // namespace octant
