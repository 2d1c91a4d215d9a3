// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_schedule.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace kleeman_schedule_test {

// L. Kleeman, section 2: six beacons 150 ms apart make a cycle of 0.9 s.
TEST(FiringSchedule, OfThePrototypeIsNineTenthsOfASecond) {
  const FiringSchedule schedule;
  EXPECT_DOUBLE_EQ(cycle_s(schedule), 0.9);
  EXPECT_DOUBLE_EQ(firing_s(schedule, BeaconId(0), 0), 0.0);
  EXPECT_DOUBLE_EQ(firing_s(schedule, BeaconId(4), 0), 0.6);
  EXPECT_DOUBLE_EQ(firing_s(schedule, BeaconId(2), 10), 9.3);
  EXPECT_DOUBLE_EQ(firing_s(schedule, BeaconId(2), -1), -0.6);
}

// Values printed in the paper for its eq. 1: 416 ms (with its own numbers) at 87 mV; 150 ms need alpha = 0.04
// with five reflections, at 200 mV.
TEST(ShortestFire, AgreesWithThePaper) {
  EXPECT_NEAR(shortest_fire_s({.threshold_v = 0.087}), 0.416, 0.0005);
  EXPECT_NEAR(shortest_fire_s({.threshold_v = 0.087, .speed_mps = 300.0}), 0.480, 0.0015);
  EXPECT_NEAR(shortest_fire_s({.absorbed_fraction = 0.04, .reflections = 5}), 0.150, 0.004);
}

/// Amplitude of an echo that has gone round for so long, after n reflections.
double echo_v(const FiringDesign& d, double fire_s) {
  double v = d.amplitude_1m_v / (fire_s * d.speed_mps);
  for (int i = 0; i < d.reflections; ++i) v *= 1 - d.absorbed_fraction;
  return v;
}

RC_GTEST_PROP(ShortestFire, IsWhenAnEchoSinksBelowTheThreshold, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  FiringDesign d;
  d.amplitude_1m_v = draws.uniform(1, 20);
  d.threshold_v = draws.uniform(0.01, 0.5);
  d.absorbed_fraction = draws.uniform(0, 0.5);
  d.reflections = *rc::gen::inRange(0, 8);
  d.speed_mps = draws.uniform(300, 360);
  const double fire_s = shortest_fire_s(d);
  RC_ASSERT(std::abs(echo_v(d, fire_s) - d.threshold_v) < 1e-12 * d.threshold_v);
  RC_ASSERT(echo_v(d, 1.01 * fire_s) < d.threshold_v);
}

}  // namespace kleeman_schedule_test
}  // namespace octant::test
