// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/shared_state.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace octant::test {
namespace shared_state_test {

Site hall_site() { return hall_scenario().site; }

/// A state with every kind of number that a state can hold.
SharedState rich_state() {
  Scenario s = hall_scenario();
  add_attenuation(s);
  s.site.attenuation->half_power_angle_rad = {0.9, 0.1};
  s.site.noise.pair_sigma_s = 1e-6;
  return prior_state(s.site);
}

// The prior mean of the delay applies once, for any owner.
TEST(PriorState, EveryArrivalIsLateByTheStatedDelayOnce) {
  const DelayPer kinds[] = {{},
                            {.beacon = true},
                            {.receiver = true},
                            {.site = true},
                            {.beacon = true, .receiver = true},
                            {.receiver = true, .site = true},
                            {.beacon = true, .receiver = true, .site = true}};
  for (const DelayPer& per : kinds) {
    Site site = hall_site();
    site.timing.delay_per = per;
    site.timing.delay_s = 7e-5;
    const SharedState state = prior_state(site);
    for (int b = 0; b < 8; ++b)
      for (int r = 0; r < 8; ++r) EXPECT_EQ(state.delay_s(BeaconId(b), ReceiverId(r)), 7e-5);
  }
}

TEST(PriorState, ABeaconsOwnDelayGoesBeforeTimings) {
  Site site = hall_site();
  site.beacons[3].delay_s = 9e-4;
  EXPECT_EQ(prior_state(site).beacon_delay_s[3], 9e-4);
  site.timing.delay_per = {.receiver = true};
  EXPECT_EQ(prior_state(site).beacon_delay_s[3], 0.0) << "beacons have none of their own then";
}

TEST(PriorState, UnknownCoordinatesAreZero) {
  Site site = hall_site();
  site.beacons[1].position_m[1].reset();
  EXPECT_EQ(prior_state(site).beacon_p_map_m[1].y(), 0.0);
  EXPECT_EQ(prior_state(site).beacon_p_map_m[1].x(), *site.beacons[1].position_m[0]);
}

TEST(PriorState, AxesCountWhereTheAttenuationIsDirectional) {
  Scenario s = hall_scenario();
  add_attenuation(s);
  EXPECT_TRUE(prior_state(s.site).receiver_axis.empty());
  s.site.attenuation->half_power_angle_rad = {0.9, 0.0};
  s.site.receivers[2].axis.reset();
  const SharedState state = prior_state(s.site);
  ASSERT_EQ(state.receiver_axis.size(), 8U);
  EXPECT_EQ(*state.axis_of(ReceiverId(1)), *s.site.receivers[1].axis);
  EXPECT_EQ(state.axis_of(ReceiverId(2))->norm(), 0.0);
  EXPECT_EQ(prior_state(hall_site()).axis_of(ReceiverId(0)), nullptr);
}

TEST(DelayOf, IsTheSumOfAllThatApply) {
  SharedState state;
  state.beacon_delay_s = {1.0, 2.0};
  state.receiver_delay_s = {10.0, 20.0, 30.0};
  state.site_delay_s = 100.0;
  EXPECT_EQ(state.delay_s(BeaconId(1), ReceiverId(2)), 132.0);
  state.pair_bias_s = {1000, 2000, 3000, 4000, 5000, 6000};  // beacon-major
  EXPECT_EQ(state.delay_s(BeaconId(0), ReceiverId(1)), 2121.0);
  EXPECT_EQ(state.delay_s(BeaconId(1), ReceiverId(2)), 6132.0);
}

TEST(SharedState, HoldsOneSpeedForAllRunsOrOneForEach) {
  SharedState state;
  EXPECT_EQ(state.speed_offset(4), 0.0);
  state.speed_offset_mps = {3.0};
  EXPECT_EQ(state.speed_offset(4), 3.0);
  state.speed_offset_mps = {3.0, 5.0};
  EXPECT_EQ(state.speed_offset(1), 5.0);
  EXPECT_EQ(state.drift(VehicleId(0)), 0.0) << "none is stated";
  EXPECT_EQ(state.log_gain(BeaconId(7)), 0.0);
}

TEST(ValueIn, FindsEachNumberAtAPlaceOfItsOwn) {
  SharedState state = rich_state();
  std::set<double*> places;
  const auto expect_own = [&](const ParameterId& id) {
    double* value = value_in(state, id);
    ASSERT_NE(value, nullptr);
    EXPECT_TRUE(places.insert(value).second);
  };
  for (std::size_t b = 0; b < 8; ++b) {
    for (std::size_t i = 0; i < 3; ++i) expect_own(parameters::beacon_position(b, i));
    expect_own(parameters::beacon_delay(b));
    expect_own(parameters::beacon_gain(b));
    for (std::size_t r = 0; r < 8; ++r) expect_own(parameters::pair_bias(b, r));
  }
  for (std::size_t r = 0; r < 8; ++r) {
    for (std::size_t i = 0; i < 3; ++i) expect_own(parameters::receiver_position(r, i));
    expect_own(parameters::receiver_delay(r));
  }
  for (std::size_t i = 0; i < kAttenuationUnknowns; ++i) expect_own(parameters::attenuation(i));
  expect_own(parameters::site_delay());
  expect_own(parameters::speed());
  expect_own(parameters::clock_drift(0));
  *value_in(state, parameters::beacon_position(3, 2)) = 77.0;
  EXPECT_EQ(state.beacon_p_map_m[3].z(), 77.0);
  *value_in(state, parameters::pair_bias(2, 5)) = 88.0;
  EXPECT_EQ(state.pair_bias_s[2 * 8 + 5], 88.0);
  state.speed_offset_mps = {0.0, 0.0, 0.0};
  *value_in(state, parameters::speed(2)) = 5.0;  // the second run, from 1
  EXPECT_EQ(state.speed_offset(1), 5.0);
}

TEST(ValueIn, IsNoneOfWhatAStateDoesNotHold) {
  SharedState state = prior_state(hall_site());
  EXPECT_EQ(value_in(state, parameters::array_radius(0)), nullptr);
  EXPECT_EQ(value_in(state, parameters::array_turn(0)), nullptr);
  EXPECT_EQ(value_in(state, parameters::attenuation(1)), nullptr);
  EXPECT_EQ(value_in(state, parameters::beacon_gain(1)), nullptr);
  EXPECT_EQ(value_in(state, parameters::clock_drift(4)), nullptr);
}

TEST(PathOf, CarriesWhatTheStateKnowsOfAPair) {
  SharedState state = rich_state();
  state.beacon_log_gain[3] = -0.2;
  state.receiver_delay_s[5] = 2e-6;
  const PathInput path = path_of(state, BeaconId(3), ReceiverId(5), 340.0);
  EXPECT_EQ(path.p_beacon_map_m, state.beacon_p_map_m[3]);
  EXPECT_EQ(path.p_receiver_vehicle_m, state.receiver_p_vehicle_m[5]);
  EXPECT_EQ(path.speed_mps, 340.0);
  EXPECT_EQ(path.delay_s, state.delay_s(BeaconId(3), ReceiverId(5)));
  EXPECT_EQ(path.attenuation, &*state.attenuation);
  EXPECT_EQ(path.axis_vehicle, &state.receiver_axis[5]);
  EXPECT_EQ(path.log_gain, -0.2);
  EXPECT_FALSE(state.has_plain_paths());
  state.attenuation.reset();
  EXPECT_TRUE(state.has_plain_paths());
  EXPECT_EQ(path_of(state, BeaconId(3), ReceiverId(5), 340.0).attenuation, nullptr);
}

TEST(SharedStateOfADeployment, IsTheTruthOfItsWorld) {
  Scenario s = hall_scenario();
  add_attenuation(s);
  s.path.epochs = s.heldout_path.epochs = 2;
  Deployment d = must(simulate(s, 4)).truth;
  d.beacons[2].gain = 0.5;
  const SharedState state = shared_state(d);
  for (std::size_t b = 0; b < 8; ++b) {
    EXPECT_EQ(state.beacon_p_map_m[b], d.beacons[b].position_m);
    EXPECT_EQ(state.delay_s(BeaconId(b), ReceiverId(1)), d.beacons[b].delay_s + d.receivers[1].delay_s);
  }
  EXPECT_EQ(state.speed_offset(0), d.speed_offset_mps);
  EXPECT_DOUBLE_EQ(state.log_gain(BeaconId(2)), std::log(0.5));
  EXPECT_EQ(state.log_gain(BeaconId(1)), 0.0);
  EXPECT_EQ(state.clock_drift.size(), d.vehicles.size());
}

/// With a number of each kind that a beacon can have, each another one.
SharedState of_all_kinds() {
  SharedState state = rich_state();
  for (std::size_t b = 0; b < state.beacon_delay_s.size(); ++b) {
    state.beacon_delay_s[b] = 1e-4 + 1e-6 * static_cast<double>(b);
    state.beacon_log_gain[b] = 0.01 * static_cast<double>(b);
    for (std::size_t r = 0; r < state.receiver_delay_s.size(); ++r)
      *value_in(state, parameters::pair_bias(b, r)) = 1e-7 * static_cast<double>(10 * b + r);
  }
  return state;
}

/// Every number that two beacons have, of two states, is the same; of pairs, where they are asked for.
void expect_alike(SharedState& one, std::size_t b, SharedState& two, std::size_t c, bool pairs) {
  for (std::size_t k = 0; k < kParameterKinds; ++k) {
    const auto kind = static_cast<ParameterKind>(k);
    const ParameterOwner owner = row_of(kind).owner;
    const bool of_pair = owner == ParameterOwner::kPair;
    if (owner != ParameterOwner::kBeacon && !(of_pair && pairs)) continue;
    const std::size_t components = of_pair                                  ? one.receiver_delay_s.size()
                                   : kind == ParameterKind::kBeaconPosition ? 3
                                                                            : 1;
    for (std::size_t i = 0; i < components; ++i) {
      const double *mine = value_in(one, parameters::of(kind, b, i)),
                   *other = value_in(two, parameters::of(kind, c, i));
      ASSERT_TRUE(mine != nullptr && other != nullptr) << "kind " << k;
      EXPECT_EQ(*mine, *other) << "kind " << k;
    }
  }
}

// A beacon split at its move once read the gain of a beacon beyond the last one.
TEST(SharedState, ACopyOfABeaconHasAllItsNumbers) {
  SharedState state = of_all_kinds();
  const std::size_t before = state.beacon_p_map_m.size();
  add_copy_of_beacon(state, 2);
  ASSERT_EQ(state.beacon_p_map_m.size(), before + 1);
  expect_alike(state, 2, state, before, true);
}

TEST(SharedState, ABeaconIsPutBackWithAllItsNumbers) {
  SharedState then = of_all_kinds(), now = then;
  now.beacon_p_map_m[3].x() += 1.0;
  now.beacon_delay_s[3] += 1e-5;
  now.beacon_log_gain[3] -= 0.5;
  set_beacon(now, 3, then);
  expect_alike(now, 3, then, 3, false);
  then.beacon_log_gain.clear();  // a state that has no such number changes none
  now.beacon_log_gain[3] = 0.25;
  set_beacon(now, 3, then);
  EXPECT_EQ(now.beacon_log_gain[3], 0.25);
}

}  // namespace shared_state_test
}  // namespace octant::test
