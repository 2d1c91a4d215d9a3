// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/state_bearings.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "models/trajectory/make_trajectory.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace state_bearings_test {

/// Numbers in the run of the bearings that a trajectory carries.
std::set<std::size_t> carried(const Trajectory& t) {
  std::set<std::size_t> numbers;
  for (const BearingObservation& b : t.bearings) numbers.insert(b.bearing);
  return numbers;
}

// Arrivals of every other twenty seconds carry the same bearings with those that it names as with all.
TEST(StateBearings, AreThoseThatStatesOfTheArrivalsCarry) {
  Scenario s = drive_scenario(120.0);
  s.site.noise.bearing_sigma_rad = 0.02;
  s.bearings = Scenario::Bearings{.period_s = 0.07};
  World world = must(simulate(s, 1));
  world.run.odometry.clear();
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return std::fmod(a.time_s, 40.0) > 20.0; });
  // Some bearings at the very instant of an arrival, as moments have them.
  for (std::size_t i = 0; i < world.run.bearings.size(); i += 3) {
    Bearing& b = world.run.bearings[i];
    const auto next = std::find_if(world.run.arrivals.begin(), world.run.arrivals.end(),
                                   [&b](const Arrival& a) { return a.time_s >= b.time_s; });
    if (next != world.run.arrivals.end() && next->time_s < b.time_s + 1.0) b.time_s = next->time_s;
  }
  std::stable_sort(world.run.bearings.begin(), world.run.bearings.end(),
                   [](const Bearing& a, const Bearing& b) { return a.time_s < b.time_s; });
  for (const bool prior : {false, true}) {
    TrajectoryModel model;
    model.medium = world.site.medium;
    model.noise = world.site.noise;
    model.motion_priors = {prior ? std::optional<MotionPrior>(MotionPrior{}) : std::nullopt};
    const std::set<std::size_t> expected = carried(make_trajectory(world.run, 0, VehicleId(0), model));
    const calib::StateBearings bearings(world.run.bearings, {state_kind(world.run, VehicleId(0), model)});
    std::set<std::size_t> found;
    std::size_t named = 0;
    for (int part = 0; part < 4; ++part) {
      MeasurementLog few = world.run;
      std::erase_if(few.arrivals,
                    [&](const Arrival& a) { return static_cast<int>(a.time_s / 40.0) != part; });
      const std::vector<std::size_t> numbers = bearings.of_states_in(few.arrivals);
      named += numbers.size();
      few.bearings.clear();
      for (const std::size_t n : numbers) few.bearings.push_back(world.run.bearings[n]);
      for (const std::size_t n : carried(make_trajectory(few, 0, VehicleId(0), model)))
        EXPECT_TRUE(found.insert(numbers[n]).second) << "carried twice";
    }
    EXPECT_EQ(found, expected);
    ASSERT_GT(found.size(), prior ? 500U : 10U);
    EXPECT_LT(named, world.run.bearings.size() * 2 / 3) << "not those of the silences";
  }
}

TEST(StateBearings, OfStopsGoByEpochAndOfTiedStopsAllAreNeeded) {
  std::vector<Bearing> bearings(6);
  for (int i = 0; i < 6; ++i) {
    bearings[static_cast<std::size_t>(i)].time_s = i;
    bearings[static_cast<std::size_t>(i)].epoch = 10 + i / 2;
    bearings[static_cast<std::size_t>(i)].vehicle = VehicleId(i % 2);
  }
  const std::vector<Arrival> heard = {{.time_s = 100.0, .vehicle = VehicleId(0), .epoch = 11},
                                      {.time_s = 101.0, .vehicle = VehicleId(1), .epoch = 12}};
  using Numbers = std::vector<std::size_t>;
  EXPECT_EQ(calib::StateBearings(bearings, {StateKind::kStops, StateKind::kStops}).of_states_in(heard),
            (Numbers{2, 5}));
  EXPECT_EQ(calib::StateBearings(bearings, {StateKind::kChainedStops, StateKind::kStops}).of_states_in(heard),
            (Numbers{0, 2, 4, 5}));
  EXPECT_EQ(calib::StateBearings(bearings, {StateKind::kChainedStops, StateKind::kStops}).of_states_in({}),
            Numbers{});
}

}  // namespace state_bearings_test
}  // namespace octant::test
