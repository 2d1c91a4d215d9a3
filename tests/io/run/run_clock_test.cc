// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_clock.h"

#include <fmt/format.h>

#include "io/run/run_folder.h"
#include "io/run/run_stream.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace run_clock_test {

using test::TemporaryFolder;
using testing::HasSubstr;

const NameTable kNames{.beacons = {"B0"}, .vehicles = {"cart"}, .receivers = {{"r0", VehicleId(0)}}};
constexpr double kPeriod_s = 4294.967296, kStep_s = 0.05;
constexpr int kRows = 6000;

/// Time of a row of a recording during which a 32-bit counter of microseconds starts again.
double counter_s(int row, double start_s = kPeriod_s - 0.5 * kRows * kStep_s) {
  const double time_s = start_s + row * kStep_s;
  return time_s < kPeriod_s ? time_s : time_s - kPeriod_s;
}

std::string tof_csv(int rows = kRows) {
  std::string text = "time_s,beacon,tof_s\n";
  for (int i = 0; i < rows; ++i) text += fmt::format("{:.6f},B0,0.0{}\n", counter_s(i), 1000 + i);
  return text;
}

void expect_continued(const std::vector<Arrival>& arrivals) {
  ASSERT_EQ(arrivals.size(), static_cast<std::size_t>(kRows));
  for (int i = 0; i < kRows; ++i) {
    const Arrival& arrival = arrivals[static_cast<std::size_t>(i)];
    ASSERT_NEAR(arrival.time_s, arrivals.front().time_s + i * kStep_s, 2e-6) << i;
    ASSERT_NEAR(arrival.tof_s, std::stod(fmt::format("0.0{}", 1000 + i)), 1e-12) << i;
  }
}

TEST(RunClock, ACounterThatStartsAgainIsContinuedWithANote) {
  const TemporaryFolder folder;
  folder.write("run/tof.csv", tof_csv());
  const auto run = read_run(folder.path("run"), kNames, {});
  ASSERT_TRUE(run) << run.error().message();
  expect_continued(run->arrivals);
  ASSERT_EQ(run->warnings.size(), 1u);
  EXPECT_THAT(run->warnings[0], HasSubstr(fmt::format("tof.csv:{}: time_s starts again", kRows / 2 + 2)));
  EXPECT_THAT(run->warnings[0], HasSubstr("a 32-bit counter of microseconds"));
}

TEST(RunClock, BlocksOfAStreamAreContinuedTooAndAreTheSameAgain) {
  const TemporaryFolder folder;
  folder.write("run/tof.csv", tof_csv());
  auto stream = RunStream::open(folder.path("run"), kNames, {}).value();
  std::vector<Arrival> all, block;
  std::vector<std::size_t> ends;
  while (stream.next(block).value()) {
    all.insert(all.end(), block.begin(), block.end());
    ends.push_back(all.size());
  }
  expect_continued(all);
  ASSERT_GT(stream.blocks(), 1u);
  for (std::size_t first = 0; first < stream.blocks(); ++first) {
    std::vector<Arrival> again;
    ASSERT_TRUE(stream.read_blocks(first, stream.blocks(), again));
    const std::size_t skipped = first == 0 ? 0 : ends[first - 1];
    ASSERT_EQ(again.size(), all.size() - skipped);
    for (std::size_t i = 0; i < again.size(); ++i) ASSERT_EQ(again[i].time_s, all[skipped + i].time_s) << i;
  }
}

TEST(RunClock, FilesThatBeginOnTheOtherSideOfTheRestartAreMoved) {
  const TemporaryFolder folder;
  folder.write("run/tof.csv", tof_csv());
  folder.write("run/bearings.csv", "time_s,reflector,bearing_rad\n1.5,B0,0.5\n");
  folder.write("run/poses.tum", "4294.9 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0 1\n");
  folder.write("run/odometry.csv", "time_s,dx_m,dy_m,dheading_rad\n2.5,0,0,0\n3.5,1,0,0\n");
  const auto run = read_run(folder.path("run"), kNames, {});
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_DOUBLE_EQ(run->bearings.front().time_s, 1.5 + kPeriod_s);
  EXPECT_DOUBLE_EQ(run->odometry.back().time_s, 3.5 + kPeriod_s);
  ASSERT_EQ(run->poses.size(), 2u);
  EXPECT_EQ(run->poses[0].time_s, 4294.9);
  EXPECT_DOUBLE_EQ(run->poses[1].time_s, 0.1 + kPeriod_s);
  EXPECT_EQ(run->warnings.size(), 2u) << "one note for each file that starts again";
}

TEST(RunClock, PosesFromBeforeTheRestartAreMovedToArrivalsAfterIt) {
  const TemporaryFolder folder;
  folder.write("run/tof.csv", "time_s,beacon,tof_s\n1,B0,0.01\n2,B0,0.01\n");
  folder.write("run/poses.tum", "4294 0 0 0 0 0 0 1\n0.5 1 0 0 0 0 0 1\n3 1 0 0 0 0 0 1\n");
  const auto run = read_run(folder.path("run"), kNames, {});
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_NEAR(run->poses[0].time_s, 4294 - kPeriod_s, 1e-9);
  EXPECT_NEAR(run->poses[2].time_s, 3.0, 1e-9);
}

TEST(RunClock, RowsThatWereSortedAfterARestartAreRestored) {
  const TemporaryFolder folder;
  std::vector<int> order(kRows);
  for (int i = 0; i < kRows; ++i) order[static_cast<std::size_t>(i)] = (i + kRows / 2) % kRows;
  std::string text = "time_s,beacon,tof_s\n";
  for (const int i : order) text += fmt::format("{:.6f},B0,0.0{}\n", counter_s(i), 1000 + i);
  folder.write("run/tof.csv", text);
  const auto run = read_run(folder.path("run"), kNames, {});
  ASSERT_TRUE(run) << run.error().message();
  expect_continued(run->arrivals);
  ASSERT_EQ(run->warnings.size(), 1u);
  EXPECT_THAT(run->warnings[0], HasSubstr("the rows were sorted after they had been recorded"));
}

TEST(RunClock, APauseWithinADayIsNoRestart) {
  MeasurementLog log;
  for (const double time_s : {100.0, 110.0, 120.0, 80000.0, 80010.0, 86390.0})
    log.arrivals.emplace_back().time_s = time_s;
  const auto before = log.arrivals;
  restore_sorted_restart(log, "tof.csv");
  EXPECT_TRUE(log.warnings.empty());
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(log.arrivals[i].time_s, before[i].time_s);
}

TEST(RunClock, TimesInMillisecondsAreNamed) {
  const TemporaryFolder folder;
  std::string text = "time_s,beacon,tof_s,epoch\n";
  for (int i = 0; i < 9000; ++i) text += fmt::format("{},B0,0.01,{}\n", 17 * i, i / 100);
  folder.write("run/tof.csv", text);
  const auto run = read_run(folder.path("run"), kNames, {});
  ASSERT_TRUE(run) << run.error().message();
  ASSERT_EQ(run->warnings.size(), 1u);
  EXPECT_THAT(run->warnings[0], HasSubstr("these seem to be milliseconds; seconds are expected"));
}

}  // namespace run_clock_test
}  // namespace octant::io
