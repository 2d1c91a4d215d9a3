// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/parameter.h"

#include <set>

#include <gtest/gtest.h>

#include "models/site.h"

namespace octant {
namespace parameter_test {

/// Names with strokes, and receivers of two vehicles that share one.
NameTable two_vehicles() {
  NameTable names;
  names.beacons = {"B1", "hall/2", "B1/r0"};
  names.vehicles = {"robot", "lift"};
  for (std::size_t v = 0; v < 2; ++v)
    for (const char* receiver : {"r0", "r/1"}) names.receivers.push_back({receiver, VehicleId(v)});
  return names;
}

std::vector<ParameterId> all_of(const NameTable& names) {
  std::vector<ParameterId> all = {parameters::site_delay(), parameters::speed(), parameters::speed(1),
                                  parameters::speed(12)};
  for (std::size_t b = 0; b < names.beacons.size(); ++b) {
    for (std::size_t i = 0; i < 3; ++i) all.push_back(parameters::beacon_position(b, i));
    all.push_back(parameters::beacon_delay(b));
    all.push_back(parameters::beacon_gain(b));
    for (std::size_t r = 0; r < names.receivers.size(); ++r) all.push_back(parameters::pair_bias(b, r));
  }
  for (std::size_t r = 0; r < names.receivers.size(); ++r) {
    for (std::size_t i = 0; i < 3; ++i) all.push_back(parameters::receiver_position(r, i));
    all.push_back(parameters::receiver_delay(r));
  }
  for (std::size_t v = 0; v < names.vehicles.size(); ++v)
    for (const ParameterId& id :
         {parameters::array_radius(v), parameters::array_turn(v), parameters::clock_drift(v)})
      all.push_back(id);
  for (std::size_t i = 0; i < 4; ++i) all.push_back(parameters::attenuation(i));
  return all;
}

TEST(Parameter, EveryKindIsFoundAgainByItsName) {
  const NameTable names = two_vehicles();
  const ParameterLookup lookup(names);
  std::set<std::string> seen;
  std::set<ParameterKind> kinds;
  for (const ParameterId& id : all_of(names)) {
    const std::string name = parameter_name(id, names);
    EXPECT_TRUE(seen.insert(name).second) << name << " stands for two";
    EXPECT_EQ(lookup.find(name), id) << name;
    kinds.insert(id.kind);
  }
  EXPECT_EQ(kinds.size(), kParameterKinds);
}

TEST(Parameter, NamesAreThoseOfTheFiles) {
  NameTable names = two_vehicles();
  EXPECT_EQ(parameter_name(parameters::beacon_position(0, 2), names), "beacon/B1/z_m");
  EXPECT_EQ(parameter_name(parameters::receiver_delay(2), names), "receiver/lift/r0/delay_s");
  EXPECT_EQ(parameter_name(parameters::speed(), names), "medium/speed_mps");
  EXPECT_EQ(parameter_name(parameters::speed(2), names), "medium/run2/speed_mps");
  EXPECT_EQ(owner_name(parameters::beacon_delay(0), names), "beacon/B1");
  names.vehicles.pop_back();
  names.receivers.resize(2);
  EXPECT_EQ(parameter_name(parameters::pair_bias(0, 0), names), "pair/B1/r0/bias_s") << "of one vehicle";
}

TEST(Parameter, WhatIsNoParameterIsNotFound) {
  const NameTable names = two_vehicles();
  const ParameterLookup lookup(names);
  for (const char* name : {"", "/", "beacon", "beacon/B1", "beacon/B9/x_m", "beacon/B1/w_m", "beacon//x_m",
                           "medium/run/speed_mps", "medium/run0/speed_mps", "medium/run99999999999/speed_mps",
                           "medium/robot/speed_mps", "site/B1/delay_s", "pair/B1/bias_s", "pair/B1/r7/bias_s",
                           "receiver/r0/x_m", "clock/robot/scale"})
    EXPECT_FALSE(lookup.find(name)) << name;
}

TEST(Parameter, EveryTopicHasWordsAndARemedy) {
  for (std::size_t k = 0; k < kParameterTopics; ++k) {
    const auto topic = static_cast<ParameterTopic>(k);
    EXPECT_STRNE(words_of(topic), "");
    EXPECT_STRNE(remedy_of(topic), "");
  }
  EXPECT_EQ(topic_of(parameters::beacon_position(0, 2)), ParameterTopic::kHeight);
  EXPECT_EQ(topic_of(parameters::beacon_gain(0)), ParameterTopic::kGain);
}

TEST(ParameterIndex, TellsWhereEachStandsAndWhichDoNot) {
  const std::vector<ParameterId> list = {parameters::speed(),
                                         parameters::beacon_position(3, 0),
                                         parameters::receiver_delay(1),
                                         parameters::beacon_position(3, 1),
                                         parameters::receiver_position(1, 2),
                                         parameters::beacon_delay(3)};
  const ParameterIndex at(list);
  for (std::size_t i = 0; i < list.size(); ++i) EXPECT_EQ(at[list[i]], static_cast<int>(i));
  EXPECT_EQ(at[parameters::site_delay()], -1);
  EXPECT_EQ(at.beacon(3), (std::array<int, 4>{1, 3, -1, 5}));
  EXPECT_EQ(at.receiver(1), (std::array<int, 4>{-1, -1, 4, 2}));
  EXPECT_EQ(at.beacon(1), (std::array<int, 4>{-1, -1, -1, -1}));
}

}  // namespace parameter_test
}  // namespace octant
