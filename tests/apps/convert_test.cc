// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Logs of other programs and devices become runs that the other commands take.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/run/run_folder.h"
#include "tests/apps/process.h"

namespace octant::test {
namespace convert_test {

using ::testing::HasSubstr;

TEST(Convert, ACarmenLogBecomesARun) {
  const TemporaryFolder box;
  std::string log = "ODOM 0 0 0 0 0 0 1 h 0.0\n";
  for (int k = 1; k < 4; ++k)
    log += "FLASER 4 1.0 1.1 1.2 1.3 0 0 0 " + std::to_string(0.5 * k) + " 0 0 1 h " + std::to_string(k) +
           ".0\n";
  spit(box / "log.clf", log);
  const Outcome done = octant({"convert", box / "log.clf", "-o", box / "run", "--json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.json()["scans"], 3);
  const auto run = io::read_run(box / "run", {{}, {"robot"}, {}}, {});
  ASSERT_TRUE(run) << run.error().found;
  ASSERT_EQ(run->scans.size(), 3u);
  ASSERT_EQ(run->odometry.size(), 4u);
  EXPECT_NEAR(run->odometry[3].dx_m, 0.5, 1e-12);
  EXPECT_EQ(octant({"convert", box / "nothing.clf", "-o", box / "other"}).exit, 3);
  EXPECT_FALSE(std::filesystem::exists(box / "other"));
}

constexpr const char* kSite =
    "octant_site: 1\nname: room\nmotion: planar\nmedium: {model: constant, speed_mps: 345.0}\ntiming: "
    "{clock: cycle_offset, delay_per: none}\n"
    "noise: {tof_sigma_s: 1.0e-5}\nbeacons:\n  - {id: B0, position_m: [0.0, 0.0, 2.0], sigma_m: 0.0}\n  - "
    "{id: B1, position_m: [9.0, 0.0, 2.0], sigma_m: 0.0}\n"
    "  - {id: B2, position_m: [9.0, 8.0, 2.0], sigma_m: 0.0}\n  - {id: B3, position_m: [0.0, 8.0, 2.0], "
    "sigma_m: 0.0}\nvehicles:\n"
    "  - {id: robot, receivers: {layout: octagon, side_m: 0.050, height_m: 0.30, sigma_m: 0.0}}\n";

/// Unlabelled pulses of a schedule: the first of each channel in a beacon's slot is that beacon's, echoes are
/// dropped.
TEST(Convert, APulseLogIsLabelled) {
  const TemporaryFolder box;
  spit(box / "site.yaml", kSite);
  std::ofstream pulses(box / "pulses.csv");
  pulses << "time_s,channel,duration_s,amplitude_v\n";
  const double x[] = {0, 9, 9, 0}, y[] = {0, 0, 8, 8};
  for (int cycle = 0; cycle < 6; ++cycle)
    for (int beacon = 0; beacon < 4; ++beacon)
      for (int twice = 0; twice < (beacon == 0 ? 2 : 1); ++twice) {
        const double flight_s =
            std::sqrt(std::pow(x[beacon] - 4.0, 2) + std::pow(y[beacon] - 3.0, 2) + 1.7 * 1.7) / 345.0;
        const double time_s = 100.0 + (4 * cycle + beacon) * 0.150 + twice * 5.5e-3 + flight_s;
        pulses << std::to_string(time_s) << ",0,0.0025,2.0\n";
        if (twice == (beacon == 0)) pulses << std::to_string(time_s + 0.02) << ",0,0.0025,0.4\n";  // an echo
      }
  pulses.close();
  const Outcome done = octant({"convert", box / "pulses.csv", "-o", box / "run", "--format", "pulses",
                               "--site", box / "site.yaml", "--json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  std::vector<std::string> beacons;
  for (const char* b : {"B0", "B1", "B2", "B3"}) beacons.emplace_back(b);
  NameTable names{beacons, {"robot"}, {}};
  for (int r = 0; r < 8; ++r) names.receivers.push_back({"r" + std::to_string(r), VehicleId(0)});
  Timing timing;
  timing.clock = Clock::kCycleOffset;
  const auto run = io::read_run(box / "run", names, timing);
  ASSERT_TRUE(run) << run.error().found;
  ASSERT_GE(run->arrivals.size(), 20u);  // 4 beacons, 6 cycles; the first may be spent on synchronisation
  for (const Arrival& a : run->arrivals) {
    // Differences between beacons of a cycle are those of the flights.
    const std::size_t b = a.beacon.index();
    const double flight_s = std::sqrt(std::pow(x[b] - 4.0, 2) + std::pow(y[b] - 3.0, 2) + 1.7 * 1.7) / 345.0;
    const double first_s = std::sqrt(16.0 + 9.0 + 1.7 * 1.7) / 345.0;
    EXPECT_NEAR(a.tof_s, flight_s - first_s, 2e-6)
        << a.epoch << " " << b;  // times are written to a microsecond
  }
  // Noise without a double pulse is no log of such a system.
  spit(box / "noise.csv", "time_s,channel,duration_s,amplitude_v\n1.0,0,0.0025,1.0\n1.3,0,0.0025,1.0\n");
  const Outcome none = octant(
      {"convert", box / "noise.csv", "-o", box / "none", "--format", "pulses", "--site", box / "site.yaml"});
  EXPECT_EQ(none.exit, 3);
  EXPECT_THAT(none.err, HasSubstr("double pulse"));
  EXPECT_FALSE(std::filesystem::exists(box / "none"));
}

TEST(Convert, CountersNeedASite) {
  const TemporaryFolder box;
  spit(box / "counts.csv",
       "time_s,epoch,beacon,receiver,counts\n0.0,0,B1,r0,200000\n0.1,0,B1,r0,200004\n0.2,0,B2,r0,300000\n");
  EXPECT_EQ(octant({"convert", box / "counts.csv", "-o", box / "run", "--format", "counters"}).exit, 2);
  spit(box / "site.yaml", kSite);
  const Outcome done =
      octant({"convert", box / "counts.csv", "-o", box / "run", "--site", box / "site.yaml", "--json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.json()["arrivals"], 2);
  EXPECT_THAT(slurp((box / "run") + "/tof.csv"), HasSubstr("0.0100001"));
}

/// Files of an earlier conversion would be read with the new ones, as one recording.
TEST(Convert, WhatStaysInTheFolderIsNamed) {
  const TemporaryFolder box;
  spit(box / "log.clf", "ODOM 0 0 0 0 0 0 1 h 0.0\nFLASER 2 1.0 1.1 0 0 0 0.5 0 0 1 h 1.0\n");
  spit(box / "kit.csv", "t,b,d\n0,A,1.5\n1,A,1.6\n");
  const Outcome first = octant({"convert", box / "log.clf", "-o", box / "run", "--json"});
  EXPECT_TRUE(first.json()["warnings"].empty()) << first.out;
  EXPECT_TRUE(octant({"convert", box / "log.clf", "-o", box / "run", "--json"}).json()["warnings"].empty());
  spit((box / "run") + "/truth.csv", "epoch,x_m,y_m\n");  // beside a recording, by hand
  const Outcome second = octant(
      {"convert", box / "kit.csv", "--columns", "time=t,beacon=b,distance=d", "-o", box / "run", "--json"});
  EXPECT_EQ(second.exit, 0) << second.err;
  ASSERT_EQ(second.json()["warnings"].size(), 1u);
  EXPECT_THAT(second.json()["warnings"][0].get<std::string>(),
              HasSubstr("scans.csv, odometry.csv are there from before"));
}

TEST(Convert, OfIgnoredBeaconsOnlyWhereThereAreSome) {
  const TemporaryFolder box;
  spit(box / "kit.csv", "t,b,d\n0,A,1.5\n0,B,2.5\n1,A,1.6\n");
  const std::vector<std::string> words = {"convert", box / "kit.csv", "--columns",
                                          "time=t,beacon=b,distance=d"};
  auto all = words, some = words;
  all.insert(all.end(), {"-o", box / "all"});
  some.insert(some.end(), {"-o", box / "some", "--ignore", "B"});
  EXPECT_THAT(octant(all).out, AllOf(HasSubstr("3 arrivals\n"), Not(HasSubstr("ignored"))));
  EXPECT_THAT(octant(some).out, HasSubstr("2 arrivals, 1 of ignored beacons\n"));
}

TEST(Convert, ATableIsUnderstoodAndExplained) {
  const TemporaryFolder box;
  spit(box / "kit.csv", "Zeit [ms];Anker;Abstand [cm];gut\n0;A1;512,5;1\n100;A2;620;0\n200;A1;513;1\n");
  const Outcome explained = octant({"convert", box / "kit.csv", "--explain"});
  ASSERT_EQ(explained.exit, 0) << explained.err;
  EXPECT_THAT(explained.out,
              AllOf(HasSubstr("time: column 'Zeit [ms]'"), HasSubstr("numbers with decimal commas"),
                    HasSubstr("not used: gut"), HasSubstr("0.1,A2,6.2")));
  EXPECT_FALSE(std::filesystem::exists(box / "run"));
  const Outcome done = octant({"convert", box / "kit.csv", "-o", box / "run", "--where", "gut=1"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("otherwise: --columns"));
  EXPECT_THAT(done.err, HasSubstr("1 rows are left out by the conditions"));
  EXPECT_EQ(slurp((box / "run") + "/tof.csv"), "time_s,beacon,distance_m\n0,A1,5.125\n0.2,A1,5.13\n");
  // A folder is needed, unless the table is only explained.
  EXPECT_EQ(octant({"convert", box / "kit.csv"}).exit, 2);
  EXPECT_EQ(octant({"convert", box / "kit.csv", "--explain", "--where", "gut"}).exit, 2);
  // The mapping that was guessed is kept.
  ASSERT_EQ(octant({"convert", box / "kit.csv", "-o", box / "a", "--save-columns", box / "m.yaml"}).exit, 0);
  ASSERT_EQ(octant({"convert", box / "kit.csv", "-o", box / "b", "--columns", box / "m.yaml"}).exit, 0);
  EXPECT_EQ(slurp((box / "a") + "/tof.csv"), slurp((box / "b") + "/tof.csv"));
}

TEST(Convert, KitsAndGraphsAreRecognisedByTheirContent) {
  const TemporaryFolder box;
  const std::pair<const char*, const char*> logs[] = {
      {"trek1000", "mc 03 000004ec 000008ee 0000087e 00000000 6cc0 0a 00000bb8 a0:0\n"},
      {"makerfabs", "1.5 {\"links\":[{\"A\":\"1782\",\"R\":\"1.03\"},{\"A\":\"1783\",\"R\":\"2.03\"}]}\n"},
      {"pyfg",
       "VERTEX_SE2 1 A0 0 0 0\nVERTEX_XY L0 3 4\nEDGE_RANGE 1 A0 L0 5 0.01\nEDGE_RANGE 2 A0 L0 5 0.01\n"}};
  for (const auto& [format, text] : logs) {
    spit(box / "log", text);
    const Outcome done = octant({"convert", box / "log", "-o", box / format, "--json"});
    ASSERT_EQ(done.exit, 0) << done.err;
    EXPECT_EQ(done.json()["format"], format);
    EXPECT_EQ(done.json()["arrivals"], 2);
    EXPECT_EQ(octant({"convert", box / "log", "-o", box / "again", "--format", format}).exit, 0);
  }
}

}  // namespace convert_test
}  // namespace octant::test
