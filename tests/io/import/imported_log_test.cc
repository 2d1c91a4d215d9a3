// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/imported_log.h"

#include <cmath>

#include "io/tof/run_parts.h"
#include "tests/io/io_support.h"
#include "tests/support/worlds.h"

namespace octant::io {
namespace imported_log_test {

using octant::test::must;
using test::expect_error;
using testing::ElementsAre;
using testing::HasSubstr;

ImportedLog log_of(const std::vector<ImportedArrival>& arrivals) {
  ImportedLog log;
  log.path = "device.log";
  for (const char* name : {"B0", "B,1", "r0"}) (void)log.names.number_of(name);
  log.arrivals = arrivals;
  return log;
}

std::string content_of(const std::vector<FileContent>& files, const std::string& path) {
  for (const FileContent& file : files)
    if (file.path == path) return file.content;
  return "none";
}

TEST(ImportedNames, AreNumberedAsTheyCome) {
  ImportedNames names;
  EXPECT_EQ(names.number_of("b"), 0);
  EXPECT_EQ(names.number_of("a"), 1);
  EXPECT_EQ(names.number_of("b"), 0);
  EXPECT_THAT(names.all(), ElementsAre("b", "a"));
  for (std::size_t i = 2; i < kMostImportedNames; ++i) (void)names.number_of(std::to_string(i));
  EXPECT_EQ(names.number_of("one more"), -1);
  EXPECT_EQ(names.number_of("a"), 1) << "known ones stay";
}

TEST(ImportedLog, HasTheColumnsThatSomeRowFills) {
  ImportedLog log =
      log_of({{.time_s = 1.5, .value = 0.01, .beacon = 0}, {.time_s = 2, .value = 0.02, .beacon = 1}});
  auto files = must(run_files(log, "run", {}));
  EXPECT_EQ(content_of(files, "run/tof.csv"), "time_s,beacon,tof_s\n1.5,B0,0.01\n2,\"B,1\",0.02\n");
  EXPECT_EQ(files.size(), 1U);
  EXPECT_THAT(log.warnings, testing::IsEmpty());
  log.arrivals[0].epoch = 7, log.arrivals[0].receiver = 2, log.arrivals[1].amplitude_v = 2.5;
  files = must(run_files(log, "run", {}));
  EXPECT_EQ(content_of(files, "run/tof.csv"),
            "time_s,beacon,tof_s,epoch,receiver,amplitude_v\n1.5,B0,0.01,7,r0,\n2,\"B,1\",0.02,,,2.5\n");
}

TEST(ImportedLog, DistancesStayThatUnlessTheirSpeedIsKnown) {
  ImportedLog log = log_of({{.time_s = 1, .value = 6.86, .is_distance = true, .beacon = 0}});
  EXPECT_EQ(content_of(must(run_files(log, "run", {})), "run/tof.csv"),
            "time_s,beacon,distance_m\n1,B0,6.86\n");
  EXPECT_EQ(content_of(must(run_files(log, "run", 343.0)), "run/tof.csv"),
            "time_s,beacon,tof_s\n1,B0,0.02\n");
  log.arrivals.push_back({.time_s = 2, .value = 0.02, .beacon = 1});
  expect_error(run_files(log, "run", {}), 0, "both times of flight and distances", "device.log");
  EXPECT_EQ(content_of(must(run_files(log, "run", 343.0)), "run/tof.csv"),
            "time_s,beacon,tof_s\n1,B0,0.02\n2,\"B,1\",0.02\n")
      << "with a speed both are times";
}

TEST(ImportedLog, RowsArePutInTheOrderOfTimeAndItIsSaid) {
  ImportedLog log = log_of({{.time_s = 3, .value = 1, .beacon = 0},
                            {.time_s = 1, .value = 2, .beacon = 0},
                            {.time_s = 3, .value = 4, .beacon = 0},
                            {.time_s = 1, .value = 3, .beacon = 0}});
  EXPECT_EQ(content_of(must(run_files(log, "run", {})), "run/tof.csv"),
            "time_s,beacon,tof_s\n1,B0,2\n1,B0,3\n3,B0,1\n3,B0,4\n")
      << "those of one instant as they came";
  EXPECT_THAT(log.warnings, ElementsAre(HasSubstr("not in the order of time")));
}

TEST(ImportedLog, WhatWasLeftOutIsCounted) {
  ImportedLog log = log_of({{.time_s = 1, .value = 2, .beacon = 0}});
  log.ignored = {{"X1", 3}, {"X2", 4}};
  log.not_heard = 5;
  EXPECT_EQ(log.ignored_rows(), 7U);
  (void)must(run_files(log, "run", {}));
  EXPECT_THAT(log.warnings,
              ElementsAre(HasSubstr("3 rows of beacon 'X1'"), HasSubstr("4 rows of beacon 'X2'"),
                          HasSubstr("5 rows without a distance")));
}

TEST(ImportedLog, NothingIsAnError) {
  ImportedLog log = log_of({});
  expect_error(run_files(log, "run", {}), 0, "no row that was asked for", "device.log");
  log.run_yaml = "octant_run: 1\n";
  expect_error(run_files(log, "run", {}), 0, "no row that was asked for");
}

/// Odometry as poses in its own frame, converted to the steps of a run: their sum gives the poses, relative
/// to the first.
TEST(ImportedLog, StepsOfTheOdometryAddUpToItsPoses) {
  for (const bool in_space : {false, true}) {
    ImportedLog log = log_of({});
    Pose T = Pose::planar(100, -50, 2.0);
    for (int i = 0; i < 40; ++i) {
      log.odometry.push_back({0.1 * i, T});
      const Eigen::Vector3d turn(in_space ? 0.05 : 0.0, in_space ? -0.02 : 0.0, 0.2);
      T = T * Pose{{0.3, 0.01 * i, in_space ? 0.02 : 0.0}, exp_rotation(turn)};
    }
    const auto poses = log.odometry;
    const std::string text = content_of(must(run_files(log, "run", {})), "run/odometry.csv");
    const NameTable names{.beacons = {}, .vehicles = {"robot"}, .receivers = {}};
    MeasurementLog run;
    const auto read = parse_odometry(text, "odometry.csv", NameLookup(names), run);
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(run.odometry.size(), poses.size());
    Pose sum = poses[0].T_map_vehicle;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      EXPECT_EQ(run.odometry[i].time_s, poses[i].time_s);
      sum = sum * run.odometry[i].pose();
      // Forty products of rotations from numbers that read back exactly.
      EXPECT_LT((sum.translation_m - poses[i].T_map_vehicle.translation_m).norm(), 1e-12 * 100);
      EXPECT_LT(sum.rotation.angularDistance(poses[i].T_map_vehicle.rotation), 1e-7);
    }
  }
}

TEST(ImportedLog, PosesAreInOrderOneAnInstantTheFirst) {
  ImportedLog log = log_of({});
  log.poses = {{2, Pose::planar(2, 0, 0)}, {1, Pose::planar(1, 0, 0)}, {2, Pose::planar(9, 0, 0)}};
  log.truth = {{1, Pose::planar(1, 0, 0)}};
  const auto files = must(run_files(log, "run", {}));
  ASSERT_EQ(files.size(), 2U);
  std::istringstream rows(content_of(files, "run/poses.tum"));
  std::vector<double> x;
  for (std::string row; std::getline(rows, row);)
    if (!row.empty() && row[0] != '#') x.push_back(std::stod(row.substr(row.find(' '))));
  EXPECT_THAT(x, ElementsAre(1, 2));
  EXPECT_THAT(log.warnings,
              ElementsAre(HasSubstr("1 poses of an instant that there was already are left out")));
  EXPECT_NE(content_of(files, "run/truth.tum"), "none");
}

}  // namespace imported_log_test
}  // namespace octant::io
