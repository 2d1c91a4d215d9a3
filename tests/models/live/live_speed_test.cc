// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/live_speed.h"

#include <gtest/gtest.h>

#include "models/simulator/synthetic.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"

namespace octant {
namespace {

/// Arrivals of a hall whose air is faster than its deployment says by so much.
World faster_hall(double by_mps) {
  Scenario scenario = test::hall_scenario();
  scenario.true_temperature_offset_degC.reset();
  scenario.true_speed_offset_mps = by_mps;
  World world = test::must(simulate(scenario, 3));
  world.truth.speed_offset_mps -= by_mps;
  return world;
}

/// The first estimate of a stream, and after how many arrivals.
std::pair<std::optional<RunSpeed>, std::size_t> first_told(LiveSpeed& speed, const MeasurementLog& run) {
  std::size_t heard = 0;
  for (const Arrival& a : run.arrivals) {
    speed.hear(a);
    ++heard;
    if (!speed.ready()) continue;
    if (auto told = speed.estimate()) return {told, heard};
  }
  return {std::nullopt, heard};
}

TEST(LiveSpeed, SomeHundredArrivalsTellTheSpeedOfAStream) {
  const World world = faster_hall(5.0);
  LiveSpeed speed(world.truth);
  const auto [told, heard] = first_told(speed, world.run);
  ASSERT_TRUE(told);
  EXPECT_TRUE(told->differs());
  EXPECT_NEAR(told->offset_mps, 5.0, 5 * told->sigma_mps);
  EXPECT_LT(heard, world.run.arrivals.size());
  EXPECT_FALSE(speed.ready()) << "all begins anew";
}

TEST(LiveSpeed, WhereTheTemperatureIsKnownNothingIsEstimated) {
  const World world = faster_hall(5.0);
  LiveSpeed speed(world.truth);
  MeasurementLog run = world.run;
  for (Arrival& a : run.arrivals) a.temperature_degC = world.truth.medium.temperature_degC;
  EXPECT_FALSE(first_told(speed, run).first);
}

}  // namespace
}  // namespace octant
