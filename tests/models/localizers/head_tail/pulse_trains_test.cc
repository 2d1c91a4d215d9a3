// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/head_tail/pulse_trains.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "tests/models/localizers/binaural_world.h"

namespace octant {
namespace {

using test::Sonar;

constexpr double kSpeed = 343.0;
constexpr double kSample_s = 0.5e-6;
constexpr double kPeriod_s = 1 / 49.4e3;

TEST(PulseTrains, PhaseIsFinerThanASample) {
  Random random(1);
  const Sonar sonar{.noise_v = 0.0};
  double phase2 = 0.0, edge2 = 0.0;
  constexpr int kTrials = 300;
  for (int k = 0; k < kTrials; ++k) {
    const double left_m = random.uniform(1.0, 1.5), right_m = left_m + random.uniform(-0.06, 0.06);
    const PulseTiming t =
        time_pulse_trains(sonar.hear(left_m, 1.0, kSpeed, random), sonar.hear(right_m, 1.0, kSpeed, random));
    ASSERT_TRUE(t.ok);
    const double truth_s = (right_m - left_m) / kSpeed;
    // No edge is off by more than half a sample, and a threshold at a few per cent of the amplitude turns the
    // phase of both trains nearly alike: asin(V/A) differs by 0.4 % of a period at most over 60 mm.
    EXPECT_LT(std::abs(t.difference_s - truth_s), kSample_s + 0.004 * kPeriod_s) << k;
    EXPECT_NEAR(t.right_tof_s - t.left_tof_s, t.difference_s, 1e-12);
    phase2 += (t.difference_s - truth_s) * (t.difference_s - truth_s);
    edge2 += (t.difference_edges_s - truth_s) * (t.difference_edges_s - truth_s);
  }
  const double phase_s = std::sqrt(phase2 / kTrials), edge_s = std::sqrt(edge2 / kTrials);
  std::cout << "rms of the difference: by phase " << 1e6 * phase_s << " us, by first edges " << 1e6 * edge_s
            << " us\n";
  // A single pair of edges is quantised to sample / sqrt(6) = 0.204 us.
  EXPECT_GT(edge_s, 0.9 * kSample_s / std::sqrt(6.0));
  EXPECT_LT(phase_s, 0.6 * edge_s);
}

TEST(PulseTrains, FirstEdgesTellTheCycle) {
  Random random(2);
  const Sonar sonar;
  for (int cycle = -8; cycle <= 8; ++cycle) {
    const double left_m = 1.5, right_m = left_m + cycle * kPeriod_s * kSpeed + 0.002;  // 2 mm of phase
    const PulseTiming t =
        time_pulse_trains(sonar.hear(left_m, 1.0, kSpeed, random), sonar.hear(right_m, 1.0, kSpeed, random));
    ASSERT_TRUE(t.ok);
    EXPECT_EQ(t.cycles, cycle);
    EXPECT_NEAR(t.phase_rad, 2 * std::numbers::pi * 0.002 / kSpeed / kPeriod_s,
                0.16);  // a sample is 0.155 rad
  }
}

TEST(PulseTrains, SilenceIsNoBurst) {
  const std::vector<std::uint8_t> silence(20000, 0), always(20000, 1);
  Random random(3);
  const auto burst = Sonar().hear(1.0, 1.0, kSpeed, random);
  EXPECT_FALSE(time_pulse_trains(silence, burst).ok);
  EXPECT_FALSE(time_pulse_trains(burst, always).ok);
  EXPECT_FALSE(time_pulse_trains({}, burst).ok);
  auto few = burst;
  int edges = 0;
  for (std::size_t i = 1; i < few.size(); ++i)
    if (few[i] != 0 && few[i - 1] == 0 && ++edges > 3) few[i] = 0;
  EXPECT_FALSE(time_pulse_trains(few, burst).ok);
}

TEST(PulseTrains, EchoBehindTheBurstIsNotHeard) {
  Random random(4);
  const Sonar sonar{.noise_v = 0.0};
  const auto left = sonar.hear(1.5, 1.0, kSpeed, random);
  auto right = sonar.hear(1.51, 1.0, kSpeed, random);
  const PulseTiming clean = time_pulse_trains(left, right);
  const auto echo = sonar.hear(2.013, 0.5, kSpeed, random);
  right.resize(std::max(right.size(), echo.size()), 0);
  for (std::size_t i = 0; i < echo.size(); ++i) right[i] = right[i] || echo[i];
  EXPECT_EQ(time_pulse_trains(left, right).difference_s, clean.difference_s);
}

}  // namespace
}  // namespace octant
