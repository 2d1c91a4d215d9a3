// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/detection_threshold.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/localizers/common/arrival_range.h"
#include "tests/models/localizers/ranging_support.h"
#include "tests/support/worlds.h"

namespace octant {
namespace {

const AttenuationModel kModel{
    .amplitude_1m_v = 12.5, .absorption_np_per_m = 0.15, .threshold_v = 0.2, .rise_time_s = 4.5e-4};
constexpr double kSpeed = 343.4;

TEST(DetectionThreshold, WhatAPulseHasToReachFallsLikeThePulse) {
  // Eq. 15 rises with the distance; the reach below the resting level V0 keeps its ratio to a pulse that is
  // absorbed alone.
  const double rest_v = 5.0, reach_v = 0.8, a = 0.15;
  double before_v = 0.0;
  for (double x = 0.5; x < 12; x += 0.5) {
    const double level_v = detection_voltage_v(x, rest_v, reach_v, a);
    EXPECT_GT(level_v, before_v);
    EXPECT_NEAR((rest_v - level_v) / std::exp(-a * x), reach_v, 1e-12);
    before_v = level_v;
  }
}

TEST(DetectionThreshold, WalkStaysLevel) {
  const AlterableThreshold alterable = alterable_threshold(kModel, 2.0);
  EXPECT_NEAR(threshold_v(2.0, alterable), kModel.threshold_v, 1e-15) << "both are the same at the reference";
  const double level_s = *crossing_time_s(2.0, kModel.threshold_v, kModel, kSpeed) - 2.0 / kSpeed;
  for (double d = 0.3; d < 12; d += 0.3)
    EXPECT_NEAR(*crossing_time_s(d, threshold_v(d, alterable), kModel, kSpeed) - d / kSpeed, level_s, 1e-16);
}

TEST(DetectionThreshold, NoiseLimitsIt) {
  const AlterableThreshold limited = alterable_threshold(kModel, 2.0, 0.05);
  EXPECT_DOUBLE_EQ(threshold_v(10.0, limited), 0.05);
  EXPECT_FALSE(crossing_time_s(40.0, 0.05, kModel, kSpeed)) << "too weak to be heard at all";
}

/// Figure 6: errors of a range at distances along a line, without (a) and with (b) compensation.
TEST(Figure6, TheErrorGrowsWithDistanceWithoutCompensationAndStaysLevelWith) {
  const AlterableThreshold alterable = alterable_threshold(kModel, 1.0);
  double before_m = 0.0, first_m = 0.0;
  for (double d = 1; d <= 9; d += 1) {
    const double without_m =
        range_without_compensation_m(*crossing_time_s(d, kModel.threshold_v, kModel, kSpeed), kSpeed) - d;
    const double altered_s = *crossing_time_s(d, threshold_v(d, alterable), kModel, kSpeed);
    EXPECT_GT(without_m, before_m + 1e-3) << "each metre adds more than a millimetre";
    EXPECT_NEAR(range_with_compensation_m(altered_s, kSpeed, alterable) - d, 0.0, 1e-12);
    if (d == 1) first_m = without_m;
    before_m = without_m;
  }
  EXPECT_GT(before_m, 10 * first_m);
  RecordProperty("without_mm_at_1_m", std::to_string(1e3 * first_m));
  RecordProperty("without_mm_at_9_m", std::to_string(1e3 * before_m));
}

/// The same with simulated arrivals, fixed threshold and the calibrated model taken out by arrival_range.
TEST(Figure6, HoldsForSimulatedArrivals) {
  Scenario s;
  s.site.medium = {.speed_mps = kSpeed};
  s.site.noise.tof_sigma_s = 1e-5;
  s.site.attenuation = AttenuationPrior{.amplitude_1m_v = {12.5, 0},
                                        .absorption_np_per_m = {0.15, 0},
                                        .rise_time_s = {4.5e-4, 0},
                                        .threshold_v = 0.2};
  s.site.beacons.push_back(test::beacon("B0", {0, 0, 0.4}, 0.0));
  test::add_receivers(s.site, {{0, 0, 0.4}});
  s.range_m = 9.5;
  s.path.kind = PathKind::kWaypoints;
  s.path.waypoints_m = {{1, 0}, {9, 0}};
  s.path.epochs = 9;
  s.path.rounds = 50;
  s.path.slot_s = 0.06;
  s.heldout_path = s.path;
  const World world = test::must(simulate(s, 3));
  Deployment blind = world.truth;
  blind.attenuation.reset();
  std::array<double, 9> without_m{}, with_m{}, share{};
  std::array<int, 9> count{};
  for (const Arrival& a : world.run.arrivals) {
    const auto k = static_cast<std::size_t>(a.epoch);
    const double d = 1.0 + static_cast<double>(a.epoch);
    without_m[k] += arrival_range(a, blind).range_m - d;
    with_m[k] += arrival_range(a, world.truth).range_m - d;
    share[k] = arrival_range(a, world.truth).sigma_m;
    ++count[k];
  }
  for (std::size_t k = 0; k < 9; ++k) {
    ASSERT_EQ(count[k], 50);
    without_m[k] /= 50;
    with_m[k] /= 50;
    // Mean of 50 with the stated sigma: 4.5 sigma is one in 100,000.
    EXPECT_NEAR(with_m[k], 0.0, 4.5 * share[k] / std::sqrt(50.0)) << k + 1 << " m";
    RecordProperty(
        "error_mm_at_" + std::to_string(k + 1) + "_m",
        std::to_string(1e3 * without_m[k]) + " without, " + std::to_string(1e3 * with_m[k]) + " with");
  }
  EXPECT_GT(without_m[8], without_m[4] + 0.02);
  EXPECT_GT(without_m[4], without_m[0] + 0.01);
}

}  // namespace
}  // namespace octant
