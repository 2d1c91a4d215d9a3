// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/foreign_logs.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace octant::test {
namespace foreign_logs_test {

using ::testing::HasSubstr;

std::string written(const std::string& text) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("octant_foreign_" + std::to_string(getpid()) + ".log"))
          .string();
  std::ofstream(path) << text;
  return path;
}

std::string flaser(int beams, const std::string& tail) {
  std::string line = "FLASER " + std::to_string(beams);
  for (int i = 0; i < beams; ++i) line += i == 3 ? " 81.83" : " 2.5";
  return line + tail;
}

TEST(CarmenLog, ScansAndOdometry) {
  const std::string path =
      written("# a comment\nPARAM robot_width 0.4\nODOM 1.0 2.0 1.5707963267948966 0 0 0 10.0 host 0.5\n" +
              flaser(180, " 9 9 9 1.0 3.0 1.5707963267948966 11.0 host 1.5\n") + "TRUEPOS 1 2 3\n" +
              flaser(181, " 9 9 9 0.0 3.0 3.141592653589793 12.0 host 2.5\n"));
  const auto log = io::read_carmen_log(path);
  ASSERT_TRUE(log) << log.error().found;
  ASSERT_EQ(log->scans.size(), 2u);
  EXPECT_EQ(log->scans[0].range_m.size(), 180u);
  EXPECT_DOUBLE_EQ(log->scans[0].angle_min_rad, -std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(log->scans[0].angle_increment_rad, std::numbers::pi / 180);
  EXPECT_DOUBLE_EQ(log->scans[1].angle_increment_rad, std::numbers::pi / 180);  // 181 readings, both ends
  EXPECT_DOUBLE_EQ(log->scans[0].range_m[2], 2.5);
  EXPECT_TRUE(std::isnan(log->scans[0].range_m[3]));
  EXPECT_DOUBLE_EQ(log->scans[1].time_s, 2.5);
  ASSERT_EQ(log->odometry.size(), 3u);
  EXPECT_EQ(log->odometry[0].dx_m, 0.0);           // the anchor
  EXPECT_NEAR(log->odometry[1].dx_m, 1.0, 1e-12);  // a metre north, heading north: straight ahead
  EXPECT_NEAR(log->odometry[1].dy_m, 0.0, 1e-12);
  EXPECT_NEAR(log->odometry[2].dy_m, 1.0, 1e-12);  // a metre west: to the left
  EXPECT_NEAR(log->odometry[2].dheading_rad, std::numbers::pi / 2, 1e-12);
  ASSERT_EQ(log->warnings.size(), 1u);
  EXPECT_THAT(log->warnings[0], HasSubstr("1 TRUEPOS"));
}

TEST(CarmenLog, ScansWithAngles) {
  const std::string path = written(
      "ROBOTLASER1 0 -1.0 2.0 0.5 30.0 0.01 0 3 1.0 2.0 30.0 1 0.5 0 0 0 4.0 5.0 0.0 0 0 0 0 0 10.0 host "
      "3.0\n");
  const auto log = io::read_carmen_log(path);
  ASSERT_TRUE(log) << log.error().found;
  ASSERT_EQ(log->scans.size(), 1u);
  EXPECT_EQ(log->scans[0].angle_min_rad, -1.0);
  EXPECT_EQ(log->scans[0].angle_increment_rad, 0.5);
  EXPECT_EQ(log->scans[0].range_m[1], 2.0);
  EXPECT_TRUE(std::isnan(log->scans[0].range_m[2]));  // the maximum range: saw nothing
}

TEST(CarmenLog, SaysWhatIsWrongAndWhere) {
  struct Case {
    const char *text, *found;
    int line, column;
  };
  for (const Case& c :
       {Case{"ODOM 1 2 3 0 0 0 1 h 1\nFLASER 3 1.0 two 3.0 0 0 0 0 0 0 1 h 1\n", "two", 2, 14},
        Case{"FLASER 3 1.0 2.0\n", "the line ends before a range", 1, 17},
        Case{"FLASER 1e9 1.0\n", "the number of readings of 1000000000", 1, 8},
        Case{"hello\n", "neither scans nor odometry", 0, 0}}) {
    const auto log = io::read_carmen_log(written(c.text));
    ASSERT_FALSE(log) << c.text;
    EXPECT_THAT(log.error().found, HasSubstr(c.found));
    EXPECT_EQ(log.error().line, c.line);
    if (c.column > 0) EXPECT_EQ(log.error().column, c.column) << c.text;
  }
}

TEST(CounterLog, IsReadAndAveragedWithoutTheOddOneOut) {
  NameTable names;
  names.beacons = {"S1", "S2"};
  names.vehicles = {"robot"};
  names.receivers = {{"head", VehicleId(0)}, {"tail", VehicleId(0)}};
  const auto readings =
      io::read_counter_log(written("time_s,epoch,beacon,receiver,counts\n"
                                   "0.0,0,S1,head,200000\n0.1,0,S1,head,200020\n0.2,0,S1,head,230000\n0.3,0,"
                                   "S1,head,200010\n0.4,0,S2,tail,100000\n"),
                           names);
  ASSERT_TRUE(readings) << readings.error().found;
  const auto arrivals = arrivals_of_counters(*readings, 1e-5);
  ASSERT_EQ(arrivals.size(), 2u);
  EXPECT_NEAR(arrivals[0].tof_s, 200010.0 / 20e6, 1e-15);  // the third is an echo
  EXPECT_EQ(arrivals[0].receiver.index(), 0u);
  EXPECT_NEAR(arrivals[1].tof_s, 5e-3, 1e-15);
  EXPECT_EQ(arrivals[1].beacon.index(), 1u);
  EXPECT_EQ(arrivals[1].epoch, 0);
  const auto strange = io::read_counter_log(written("time_s,beacon,receiver,counts\n0.0,S3,head,1\n"), names);
  ASSERT_FALSE(strange);
  EXPECT_EQ(strange.error().line, 2);
  EXPECT_THAT(strange.error().found, HasSubstr("S3"));
}

TEST(PulseLog, RefusesWhatIsNoPulse) {
  ASSERT_TRUE(io::read_pulse_log(written("time_s,channel,duration_s,amplitude_v\n0.1,7,0.0025,1.5\n")));
  for (const char* row : {"0.1,16,0.0025,1.5", "0.1,-1,0.0025,1.5", "0.1,0,0,1.5", "0.1,0,0.0025,"})
    EXPECT_FALSE(
        io::read_pulse_log(written(std::string("time_s,channel,duration_s,amplitude_v\n") + row + "\n")))
        << row;
}

}  // namespace foreign_logs_test
}  // namespace octant::test
