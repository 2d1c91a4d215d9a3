// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Counts by hand; for simulated halls see tests/calib/plan/check_test.cc.
#include "calib/problem/log_health.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/repeated_row.h"
#include "models/simulator/random.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace log_health_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Two beacons 10 m apart, and this number of vehicles with one receiver each; sound at 340 m/s.
Site small_site(int vehicles = 1) {
  Site site;
  site.medium = {.model = MediumModel::kConstant, .speed_mps = 340.0};
  site.beacons = {beacon("B0", {0, 0, 2}, 0.0), beacon("B1", {10, 0, 2}, 0.0)};
  for (int v = 0; v < vehicles; ++v) add_receivers(site, {{0, 0, 0}}, 0.0, "robot" + std::to_string(v));
  return site;
}

Arrival arrival(double time_s, int beacon, int vehicle = 0, std::int64_t epoch = kNoEpoch) {
  Arrival a;
  a.time_s = time_s;
  // Distances of some metres that never repeat.
  a.tof_s = 0.015 + 1e-3 * std::sin(7.0 * time_s + beacon);
  a.beacon = BeaconId(beacon);
  a.receiver = ReceiverId(vehicle);
  a.vehicle = VehicleId(vehicle);
  a.epoch = epoch;
  return a;
}

/// Epochs of one vehicle, two arrivals each.
MeasurementLog stops(int epochs, double period_s) {
  MeasurementLog log;
  log.path = "run";
  log.has_epochs = true;
  for (int e = 0; e < epochs; ++e)
    for (int b = 0; b < 2; ++b) log.arrivals.push_back(arrival(period_s * e + 0.05 * b, b, 0, e));
  return log;
}

std::vector<std::string> texts(const calib::RunHealth& h, const std::string& kind) {
  std::vector<std::string> found;
  for (const calib::Finding& f : h.findings)
    if (f.kind == kind) found.push_back(f.text);
  return found;
}

TEST(LogHealth, OfNothingIsNothing) {
  const calib::RunHealth h = calib::log_health(small_site(), MeasurementLog());
  EXPECT_EQ(h.arrivals + h.bearings + h.instants + h.rows + h.duplicates, 0U);
  EXPECT_EQ(h.duration_s, 0.0);
  EXPECT_EQ(h.median_range_m, 0.0);
  EXPECT_THAT(h.findings, IsEmpty());
  ASSERT_THAT(h.beacons, SizeIs(2));
  EXPECT_EQ(h.beacons[0].rate_hz, 0.0);
  EXPECT_THAT(h.receivers, IsEmpty()) << "no vehicle appears";
}

TEST(LogHealth, OfOneArrivalHasNoRate) {
  MeasurementLog log;
  log.arrivals = {arrival(3.0, 1)};
  const calib::RunHealth h = calib::log_health(small_site(), log);
  EXPECT_EQ(h.instants, 1U);
  EXPECT_EQ(h.duration_s, 0.0);
  EXPECT_EQ(h.beacons[1].arrivals, 1U);
  EXPECT_EQ(h.beacons[1].rate_hz, 0.0);
  EXPECT_NEAR(h.median_range_m, 340.0 * log.arrivals[0].tof_s, 1e-12);
}

TEST(LogHealth, RatesAndSilencesAreThoseOfTheRun) {
  MeasurementLog log;
  for (int i = 0; i <= 10; ++i) log.arrivals.push_back(arrival(i, 0));
  log.arrivals.insert(log.arrivals.begin() + 5, arrival(4.0, 1));  // beacon 1 once, after four of ten seconds
  Bearing b;
  b.time_s = 5.0;
  b.reflector = BeaconId(1);
  b.vehicle = VehicleId(0);
  log.bearings = {b};
  b.time_s = 10.0;
  b.reflector = BeaconId();  // of an unknown reflector
  log.bearings.push_back(b);
  const calib::RunHealth h = calib::log_health(small_site(), log);
  EXPECT_EQ(h.duration_s, 10.0);
  EXPECT_EQ(h.instants, 11U);
  EXPECT_DOUBLE_EQ(h.beacons[0].rate_hz, 1.1);
  EXPECT_EQ(h.beacons[0].longest_silence_s, 1.0);
  EXPECT_EQ(h.beacons[1].arrivals, 2U) << "bearings included";
  EXPECT_EQ(h.beacons[1].longest_silence_s, 5.0) << "the run's end included";
  EXPECT_EQ(h.receivers[0].name, "robot0/r0");
  EXPECT_EQ(h.receivers[0].arrivals, 12U);
  log.bearings[0].time_s = 6.0;
  log.arrivals[5].time_s = 6.0;
  EXPECT_EQ(calib::log_health(small_site(), log).beacons[1].longest_silence_s, 6.0) << "and its beginning";
}

TEST(LogHealth, APauseIsOneBeyondTenTimesTheUsual) {
  MeasurementLog log = stops(20, 2.0);
  for (Arrival& a : log.arrivals) a.time_s += a.epoch >= 12 ? 17.5 : 0.0;
  EXPECT_THAT(calib::log_health(small_site(), log).gaps, IsEmpty());
  for (Arrival& a : log.arrivals) a.time_s += a.epoch >= 12 ? 0.3 : 0.0;
  for (Arrival& a : log.arrivals) a.time_s += a.epoch >= 4 ? 100.0 : 0.0;
  const calib::RunHealth h = calib::log_health(small_site(), log);
  ASSERT_THAT(h.gaps, SizeIs(2));
  EXPECT_NEAR(h.gaps[0].to_s - h.gaps[0].from_s, 101.95, 1e-9) << "the longest first";
  EXPECT_NEAR(h.gaps[1].to_s - h.gaps[1].from_s, 19.75, 1e-9);
  ASSERT_THAT(texts(h, "gap"), SizeIs(1));
  EXPECT_THAT(texts(h, "gap")[0],
              HasSubstr("run: 2 pauses without any arrival, the longest 102 s from 6.05 s"));
}

// The rows of two vehicles that stop side by side follow each other within an epoch.
TEST(LogHealth, OfTwoVehiclesTheirEpochsAreTheInstantsAndTheirStopsNoPauses) {
  MeasurementLog log;
  log.has_epochs = true;
  for (int e = 0; e < 40; ++e)
    for (int i = 0; i < 4; ++i) log.arrivals.push_back(arrival(5.0 * e + 0.05 * i, i / 2, i % 2, e));
  const calib::RunHealth h = calib::log_health(small_site(2), log);
  EXPECT_EQ(h.instants, 80U) << "epochs of each";
  EXPECT_THAT(h.gaps, IsEmpty());
  EXPECT_THAT(texts(h, "gap"), IsEmpty());
}

TEST(LogHealth, CountsWhatReadersLeftOutByItsReason) {
  MeasurementLog log = stops(5, 1.0);
  log.rows = 13;
  log.rejected = {{3, "tof_s is not a number"}, {7, kRepeatedRow}, {9, "tof_s is not a number"}};
  const calib::RunHealth h = calib::log_health(small_site(), log);
  EXPECT_EQ(h.rows, 13U);
  EXPECT_EQ(h.rejected.at("tof_s is not a number"), 2U);
  EXPECT_EQ(h.duplicates, 1U);
  EXPECT_THAT(texts(h, "duplicate"), IsEmpty()) << "those that are out already count but once";
}

TEST(LogHealth, ARepeatedRowIsNamedByItsLine) {
  MeasurementLog log = stops(5, 1.0);
  for (std::size_t i = 0; i < log.arrivals.size(); ++i) log.arrivals[i].line = static_cast<int>(i) + 2;
  Arrival twice = log.arrivals[4];
  twice.line = 77;
  log.arrivals.insert(log.arrivals.begin() + 5, twice);
  const calib::RunHealth h = calib::log_health(small_site(), log);
  EXPECT_EQ(h.duplicates, 1U);
  ASSERT_THAT(texts(h, "duplicate"), SizeIs(1));
  EXPECT_THAT(texts(h, "duplicate")[0], HasSubstr("line 77"));
}

TEST(LogHealth, RowsThatRunBackwardsAreCounted) {
  MeasurementLog log = stops(6, 1.0);
  std::swap(log.arrivals[3].time_s, log.arrivals[4].time_s);
  const calib::RunHealth h = calib::log_health(small_site(), log);
  EXPECT_EQ(h.backwards, 1U);
  EXPECT_THAT(texts(h, "time_backwards"), ElementsAre(HasSubstr("in 1 rows")));
}

TEST(LogHealth, TellsHowMuchOdometryAndPosesAccompany) {
  MeasurementLog log;
  log.path = "run";
  for (int i = 0; i < 100; ++i) log.arrivals.push_back(arrival(i, i % 2));
  for (int i = 20; i <= 79; ++i) {
    if (i > 40 && i < 47) continue;
    log.odometry.push_back({.time_s = static_cast<double>(i), .vehicle = VehicleId(0)});
  }
  log.vehicle = VehicleId(0);
  log.pose_accuracy.max_gap_s = 2.0;
  for (int i = 0; i < 100; i += 2) log.poses.push_back({static_cast<double>(i), Pose()});
  const calib::RunHealth h = calib::log_health(small_site(), log);
  EXPECT_EQ(h.odometry.rows, 54U);
  EXPECT_DOUBLE_EQ(h.odometry.share, 0.6);
  EXPECT_EQ(h.odometry.longest_gap_s, 7.0);
  EXPECT_DOUBLE_EQ(h.poses.share, 0.99);
  EXPECT_THAT(texts(h, "coverage"),
              ElementsAre(HasSubstr("odometry.csv accompanies 60 % of the arrivals only (longest gap 7 s)")));
}

TEST(LogHealth, PointsOfSomeStopsRunOnNoClock) {
  MeasurementLog log = stops(20, 1.0);
  log.vehicle = VehicleId(0);
  log.poses = {{log.arrivals.front().time_s, Pose()}};
  EXPECT_THAT(texts(calib::log_health(small_site(), log), "coverage"),
              ElementsAre(HasSubstr("poses.tum accompanies")));
  log.sha256["run/points.csv"] = "";
  EXPECT_THAT(texts(calib::log_health(small_site(), log), "coverage"), ElementsAre());
}

TEST(LogHealth, ATemperatureOfSomeArrivalsIsSaid) {
  Site site = small_site();
  site.medium = {.model = MediumModel::kCramer1993, .temperature_degC = 12.0};
  site.speed_sigma_mps = 2.0;
  MeasurementLog log = stops(10, 1.0);
  for (std::size_t i = 0; i < 5; ++i) log.arrivals[i].temperature_degC = 15.0;
  const calib::RunHealth h = calib::log_health(site, log);
  EXPECT_DOUBLE_EQ(h.temperature_share, 0.25);
  EXPECT_THAT(texts(h, "temperature"), ElementsAre(HasSubstr("15 of 20 arrivals have no temperature")));
}

TEST(SilentLinks, AreThoseThatNoRunHears) {
  const Site site = small_site(2);
  MeasurementLog first = stops(5, 1.0), second;
  std::erase_if(first.arrivals, [](const Arrival& a) { return a.beacon == BeaconId(1); });
  const std::vector<calib::RunHealth> one = {calib::log_health(site, first)};
  const auto found = calib::silent_links(site, one);
  ASSERT_THAT(found, SizeIs(1)) << "a vehicle that does not appear is not deaf";
  EXPECT_EQ(found[0].kind, "silent_beacon");
  EXPECT_THAT(found[0].text, HasSubstr("B1"));
  second.arrivals = {arrival(0.0, 1, 0), arrival(1.0, 0, 0)};
  EXPECT_THAT(calib::silent_links(site, {one[0], calib::log_health(site, second)}), IsEmpty());
  EXPECT_THAT(calib::silent_links(site, {calib::log_health(site, second)}), IsEmpty())
      << "two arrivals are some";
}

// --- The counter ---------------------------------------------------------------------------------------

RC_GTEST_PROP(CounterResolution, IsTheStepOfValuesThatAreMultiplesOfIt, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const double step_s = std::pow(10.0, draws.uniform(-9, -4)), phase_s = draws.uniform(0, 1) * step_s;
  std::vector<double> values;
  for (int i = 0; i < 400; ++i) values.push_back(phase_s + step_s * std::floor(draws.uniform(100, 400)));
  // Two neighbouring ticks are among 400 of 300; sums of steps lose a rounding each.
  RC_ASSERT(std::abs(calib::counter_resolution_s(values) - step_s) < 1e-6 * step_s);
}

TEST(CounterResolution, OfContinuousFewOrEqualValuesIsNone) {
  Random draws(5);
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) values.push_back(0.01 + 0.01 * draws.uniform(0, 1));
  EXPECT_EQ(calib::counter_resolution_s(values), 0.0);
  EXPECT_EQ(calib::counter_resolution_s(std::vector<double>(1000, 0.01)), 0.0);
  values.clear();
  for (int i = 0; i < 49; ++i) values.push_back(0.01 + 1e-5 * i);
  EXPECT_EQ(calib::counter_resolution_s(values), 0.0) << "49 are too few";
  values.push_back(0.02);
  EXPECT_GT(calib::counter_resolution_s(values), 0.0);
  EXPECT_EQ(calib::counter_resolution_s({}), 0.0);
}

}  // namespace log_health_test
}  // namespace octant::test
