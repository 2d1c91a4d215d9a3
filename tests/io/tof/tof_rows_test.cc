// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/tof_rows.h"

#include <cmath>
#include <limits>

#include "tests/io/io_support.h"

namespace octant::io {
namespace tof_rows_test {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// 0 dBm is a milliwatt: 0.22361 V effective over 50 ohm, the radio engineer's 224 mV; 20 dB are ten times it.
TEST(TofRows, LevelsAreVoltsIntoFiftyOhm) {
  EXPECT_NEAR(amplitude_of_level(0.0), 0.2236068, 1e-7);
  EXPECT_NEAR(amplitude_of_level(13.0103), 1.0, 1e-5) << "a volt over 50 ohm is 20 mW";
  for (const double dbm : {-90.0, -40.0, 3.0})
    EXPECT_NEAR(amplitude_of_level(dbm + 20) / amplitude_of_level(dbm), 10.0, 1e-12);
}

TEST(TofRows, AmplitudesThatAreNoneAreNotLogged) {
  EXPECT_EQ(usable_amplitude(1e-300), 1e-300);
  for (const double none : {0.0, -1.0, kInf, -kInf, kNan})
    EXPECT_TRUE(std::isnan(usable_amplitude(none))) << none;
  EXPECT_TRUE(is_temperature(-100) && is_temperature(100) && is_temperature(kNan));
  EXPECT_FALSE(is_temperature(100.1) || is_temperature(293.15) || is_temperature(kInf));
}

TEST(TofRows, TimesThatAreNoMeasurementHaveAReason) {
  using enum Refusal;
  for (const Clock clock : {Clock::kSynchronised, Clock::kCycleOffset}) {
    EXPECT_EQ(refusal_of("", kNan, clock), kEmpty);
    EXPECT_EQ(refusal_of("nan", kNan, clock), kNotANumber);
    EXPECT_EQ(refusal_of("inf", kInf, clock), kNotANumber);
    EXPECT_EQ(refusal_of("1", 1.0, clock), kNone);
    EXPECT_EQ(refusal_of("39437131", 39437131.0, clock), kNone) << "nanoseconds are told as such";
    EXPECT_EQ(refusal_of("1e160", 1e160, clock), kTooLarge);
    EXPECT_EQ(refusal_of("-1e160", -1e160, clock), kTooLarge);
  }
  EXPECT_EQ(refusal_of("0", 0.0, Clock::kSynchronised), kNotPositive);
  EXPECT_EQ(refusal_of("-1", -1.0, Clock::kSynchronised), kNotPositive);
  EXPECT_EQ(refusal_of("-1", -1.0, Clock::kCycleOffset), kNone) << "the offset is not known yet";
}

TEST(TofRefusals, AreWarnedOfOnceForEachReasonWithTheFirstOne) {
  TofRefusals refusals;
  refusals.add(Refusal::kNotPositive, 9, "-0.5");
  refusals.add(Refusal::kNotANumber, 4, "nan");
  refusals.add(Refusal::kNotPositive, 12, "-0.7");
  refusals.add(Refusal::kEmpty, 5, "");
  std::vector<std::string> warnings;
  refusals.warn("t.csv", warnings);
  EXPECT_THAT(warnings,
              ElementsAre("t.csv:5: tof_s is empty; 1 arrival rejected for this reason",
                          "t.csv:4: tof_s is not a number (nan); 1 arrival rejected for this reason",
                          "t.csv:9: tof_s is not positive (-0.5); 2 arrivals rejected for this reason"));
}

TEST(TofRefusals, AreTakenByLineAndOnlyOnce) {
  TofRefusals refusals;
  for (const int line : {9, 4, 12, 5}) refusals.add(Refusal::kNotANumber, line, "x");
  std::vector<int> lines;
  for (const RejectedRow& row : refusals.take()) {
    lines.push_back(row.line);
    EXPECT_EQ(row.reason, "tof_s is not a number");
  }
  EXPECT_THAT(lines, ElementsAre(4, 5, 9, 12));
  refusals.add(Refusal::kRepeated, 3, "x");
  EXPECT_EQ(refusals.take().size(), 1U);
  EXPECT_TRUE(refusals.take().empty());
  std::vector<std::string> warnings;
  refusals.warn("t.csv", warnings);
  EXPECT_EQ(warnings.size(), 2U) << "all are counted";
}

const NameTable kNames{.beacons = {"B0", "B1"}, .vehicles = {"robot"}, .receivers = {{"r0", VehicleId(0)}}};

struct Read {
  std::vector<Arrival> arrivals;
  std::string error;
};
Read read(const std::string& text, const DistanceAsTime& as_time = {}) {
  CsvReader csv(text, "t.csv");
  const TofColumns columns(csv, as_time);
  const NameLookup names(kNames);
  OrderWatch order(1, columns.time, columns.epoch);
  Read out;
  Arrival arrival;
  while (csv.next_row() && read_tof_row(csv, columns, names, order, arrival = Arrival{}))
    out.arrivals.push_back(arrival);
  if (csv.error()) out.error = csv.error()->message();
  return out;
}

TEST(TofRows, ARowIsItsCells) {
  const Read r = read(
      "epoch,tof_s,beacon,time_s,receiver,vehicle,amplitude_v,temperature_degC,received_s\n"
      "7,0.01,B1,2.5,r0,robot,1.25,21.5,2.75\n");
  ASSERT_EQ(r.error, "");
  const Arrival& a = r.arrivals.at(0);
  EXPECT_EQ(a.epoch, 7);
  EXPECT_EQ(a.tof_s, 0.01);
  EXPECT_EQ(a.beacon, BeaconId(1));
  EXPECT_EQ(a.time_s, 2.5);
  EXPECT_EQ(a.receiver, ReceiverId(0));
  EXPECT_EQ(a.amplitude_v, 1.25);
  EXPECT_EQ(a.temperature_degC, 21.5);
  EXPECT_EQ(a.received_after_s, 0.25F);
  EXPECT_EQ(a.line, 2);
}

TEST(TofRows, WhatIsNotThereIsNotLogged) {
  const Arrival a = read("time_s,beacon,tof_s\n1,B0,0.01\n").arrivals.at(0);
  EXPECT_EQ(a.epoch, kNoEpoch);
  EXPECT_TRUE(std::isnan(a.amplitude_v) && std::isnan(a.temperature_degC) && std::isnan(a.received_after_s));
  EXPECT_TRUE(std::isnan(read("time_s,beacon,tof_s\n1,B0,\n").arrivals.at(0).tof_s));
}

TEST(TofRows, ALevelStandsInWhereThereIsNoAmplitude) {
  const auto amplitudes = [](const std::string& cells) {
    return read("time_s,beacon,tof_s,amplitude_v,level_dbm\n1,B0,0.01," + cells + "\n")
        .arrivals.at(0)
        .amplitude_v;
  };
  EXPECT_EQ(amplitudes("2,0"), 2.0);
  EXPECT_NEAR(amplitudes(",0"), 0.2236068, 1e-7);
  EXPECT_NEAR(amplitudes("-1,0"), 0.2236068, 1e-7) << "a negative amplitude is none";
  EXPECT_TRUE(std::isnan(amplitudes(",")));
}

TEST(TofRows, DistancesStandForTimesOnlyAtAKnownSpeed) {
  const std::string text = "time_s,beacon,distance_m\n1,B0,6.86\n";
  EXPECT_THAT(read(text).error,
              HasSubstr("'distance_m' stands for it only where the medium's speed is constant"));
  EXPECT_EQ(read(text, {.per_m_s = 1 / 343.0}).arrivals.size(), 1U);
  const Read both = read("time_s,beacon,distance_m,tof_s\n1,B0,6.86,0.02\n", {.per_m_s = 1 / 343.0});
  EXPECT_EQ(both.arrivals.at(0).tof_s, 0.02) << "a time is a time";
}

TEST(TofRows, FaultsAreNamedAtTheirCells) {
  EXPECT_THAT(read("time_s,beacon,tof_s\nx,B0,0.01\n").error, HasSubstr("t.csv:2:1"));
  EXPECT_THAT(read("time_s,beacon,tof_s\n1,B0,x\n").error, HasSubstr("t.csv:2:6: tof_s is 'x'"));
  EXPECT_THAT(read("time_s,beacon,tof_s\n2,B0,1\n1,B0,1\n").error, HasSubstr("t.csv:3:1: time_s goes back"));
  EXPECT_THAT(read("time_s,beacon,tof_s,epoch\n1,B0,1,1.5\n").error, HasSubstr("t.csv:2:8"));
  EXPECT_THAT(read("time_s,beacon,tof_s,temperature_degC\n1,B0,1,293.15\n").error,
              HasSubstr("temperature_degC is 293.15; expected degrees Celsius from -100 to 100"));
}

}  // namespace tof_rows_test
}  // namespace octant::io
