// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/live_speed.h"

#include <chrono>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "models/simulator/synthetic.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"

namespace octant {
namespace live_speed_test {

/// Arrivals of a hall in which sound is faster than in its deployment by this amount.
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
    if (auto new_estimate = speed.new_estimate()) return {new_estimate, heard};
  }
  return {std::nullopt, heard};
}

TEST(LiveSpeed, SomeHundredArrivalsTellTheSpeedOfAStream) {
  const World world = faster_hall(5.0);
  LiveSpeed speed(world.truth);
  const auto [new_estimate, heard] = first_told(speed, world.run);
  ASSERT_TRUE(new_estimate);
  EXPECT_TRUE(new_estimate->differs());
  EXPECT_NEAR(new_estimate->offset_mps, 5.0, 5 * new_estimate->sigma_mps);
  EXPECT_LT(heard, world.run.arrivals.size());
}

// The results, and the arrivals after which they come, depend on the stream alone, however long an estimate
// took.
TEST(LiveSpeed, IsToldAfterAsManyArrivalsMoreAsItIsMadeOf) {
  const World world = faster_hall(5.0);
  LiveSpeed slow(world.truth), fast(world.truth);
  std::vector<std::pair<std::size_t, double>> at_leisure, at_once;
  for (std::size_t i = 0; i < world.run.arrivals.size(); ++i) {
    if (i % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    slow.hear(world.run.arrivals[i]);
    if (const auto new_estimate = slow.new_estimate())
      at_leisure.emplace_back(i + 1, new_estimate->offset_mps);
  }
  for (std::size_t i = 0; i < world.run.arrivals.size(); ++i) {
    fast.hear(world.run.arrivals[i]);
    if (const auto new_estimate = fast.new_estimate()) at_once.emplace_back(i + 1, new_estimate->offset_mps);
  }
  EXPECT_EQ(at_leisure, at_once);
  ASSERT_FALSE(at_once.empty());
  // Made of the first 400 arrivals (or two, four times that number), like a recording that ends there.
  const std::size_t made_of = at_once.front().first / 2;
  EXPECT_EQ(made_of % 400, 0u);
  MeasurementLog part = world.run;
  part.arrivals.resize(made_of);
  EXPECT_EQ(estimate_run_speed(world.truth, part).offset_mps, at_once.front().second);
}

// At thousands of arrivals a second, the number of arrivals of an estimate comes before it can be computed: a
// request for it then would block, and with it the fixes.
TEST(LiveSpeed, OfAFastStreamAnEstimateHasSecondsAndTheNextOneRests) {
  const World world = faster_hall(5.0);
  constexpr double kRate_per_s = 1'000.0;
  LiveSpeed speed(world.truth);
  std::vector<double> told_s;
  const std::size_t n = world.run.arrivals.size();
  for (std::size_t i = 0; i < 40'000; ++i) {
    Arrival a = world.run.arrivals[i % n];
    a.epoch = static_cast<decltype(a.epoch)>(i / n) * 1'000'000 + a.epoch;
    a.time_s = static_cast<double>(i) / kRate_per_s;
    speed.hear(a);
    if (const auto new_estimate = speed.new_estimate()) {
      EXPECT_NEAR(new_estimate->offset_mps, 5.0, 5 * new_estimate->sigma_mps);
      told_s.push_back(a.time_s);
    }
  }
  ASSERT_GE(told_s.size(), 2u);
  EXPECT_GE(told_s.front(), 2.39);  // of the first 400 arrivals, two seconds later
  for (std::size_t k = 1; k < told_s.size(); ++k) EXPECT_GE(told_s[k] - told_s[k - 1], 10.0);
}

TEST(LiveSpeed, AClockThatStandsIsNotWaitedFor) {
  const World world = faster_hall(5.0);
  LiveSpeed speed(world.truth);
  bool new_estimate = false;
  for (std::size_t i = 0; i < 110'000 && !new_estimate; ++i) {
    Arrival a = world.run.arrivals[i % world.run.arrivals.size()];
    a.time_s = 0.0;
    speed.hear(a);
    new_estimate = speed.new_estimate().has_value();
  }
  EXPECT_TRUE(new_estimate);
}

TEST(LiveSpeed, AnEstimateThatRunsMayBeAbandoned) {
  const World world = faster_hall(5.0);
  auto speed = std::make_unique<LiveSpeed>(world.truth);
  for (std::size_t i = 0; i < 420; ++i) {
    speed->hear(world.run.arrivals[i]);
    EXPECT_FALSE(speed->new_estimate());
  }
  speed.reset();  // waits for its thread
}

TEST(LiveSpeed, WhereTheTemperatureIsKnownNothingIsEstimated) {
  const World world = faster_hall(5.0);
  LiveSpeed speed(world.truth);
  MeasurementLog run = world.run;
  for (Arrival& a : run.arrivals) a.temperature_degC = world.truth.medium.temperature_degC;
  EXPECT_FALSE(first_told(speed, run).first);
}

}  // namespace live_speed_test
}  // namespace octant
