// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// points.csv, truth.csv, and distances in place of times.
#include <cmath>

#include "io/run/run_folder.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace run_points_test {

using test::expect_error;
using test::TemporaryFolder;
using testing::HasSubstr;

const NameTable kOne{.beacons = {"B0", "B1"}, .vehicles = {"robot"}, .receivers = {{"r0", VehicleId(0)}}};
const std::string kStops =
    "time_s,beacon,tof_s,epoch\n1,B0,0.01,7\n1.5,B1,0.01,7\n9,B0,0.01,8\n20,B0,0.02,9\n";

Result<MeasurementLog> read_with(const std::string& tof, const std::string& name, const std::string& text,
                                 const ReadRunOptions& options = {.read_truth = true}, Timing timing = {}) {
  const TemporaryFolder folder;
  folder.write("run/tof.csv", tof);
  if (!name.empty()) folder.write("run/" + name, text);
  return read_run(folder.path("run"), kOne, timing, options);
}

TEST(RunPoints, BelongToTheirEpochs) {
  const auto log =
      read_with(kStops, "points.csv", "epoch,x_m,y_m,z_m,sigma_m\n9,3,4,0.5,0.02\n7,1,2,,0.02\n").value();
  ASSERT_EQ(log.poses.size(), 3u);  // the first and last instant of epoch 7, the one of epoch 9
  EXPECT_EQ(log.poses[0].time_s, 1.0);
  EXPECT_EQ(log.poses[1].time_s, 1.5);
  EXPECT_EQ(log.poses[0].T_map_vehicle.translation_m, Eigen::Vector3d(1, 2, 0));
  EXPECT_EQ(log.poses[2].time_s, 20.0);
  EXPECT_EQ(log.poses[2].T_map_vehicle.translation_m, Eigen::Vector3d(3, 4, 0.5));
  EXPECT_DOUBLE_EQ(log.pose_accuracy.position_sigma_m, 0.02);
  EXPECT_FALSE(log.pose_accuracy.heading_known);
  EXPECT_LT(log.pose_accuracy.max_gap_s, 1.0) << "nothing is known between two stops";
  EXPECT_TRUE(log.truth.empty());
}

TEST(RunPoints, AreAReferenceInTruthCsv) {
  const auto log =
      read_with(kStops, "truth.csv", "epoch,x_m,y_m,heading_rad,heading_sigma_rad\n8,1,2,0.5,0.03\n").value();
  ASSERT_EQ(log.truth.size(), 1u);
  EXPECT_EQ(log.truth[0].time_s, 9.0);
  EXPECT_NEAR(log.truth[0].T_map_vehicle.heading_rad(), 0.5, 1e-12);
  EXPECT_TRUE(log.truth_accuracy.heading_known);
  EXPECT_DOUBLE_EQ(log.truth_accuracy.heading_sigma_rad, 0.03);
  EXPECT_TRUE(log.poses.empty());
  EXPECT_TRUE(read_with(kStops, "truth.csv", "rubbish\n", {}).has_value()) << "only verify opens it";
}

TEST(RunPoints, SayWhatIsWrongAndWhere) {
  const auto points = [](const std::string& text) { return read_with(kStops, "points.csv", text); };
  expect_error(points("epoch,x_m\n7,1\n"), 1, "'y_m' is missing", "points.csv");
  expect_error(points("epoch,x_m,y_m\n7,1,2\n7,1,3\n"), 3, "a second time", "points.csv");
  expect_error(points("epoch,x_m,y_m\n7,one,2\n"), 2, "'one'", "points.csv");
  expect_error(points("epoch,x_m,y_m,sigma_m\n7,1,2,-1\n"), 2, "sigma_m is -1", "points.csv");
  expect_error(points("epoch,x_m,y_m\n7,1e160,2\n"), 2, "x_m is '1e160'; expected metres", "points.csv");
  expect_error(points("epoch,x_m,y_m,heading_rad\n7,1,2,90\n"), 2, "heading_rad is 90", "points.csv");
  expect_error(read_with("time_s,beacon,tof_s\n1,B0,0.01\n", "points.csv", "epoch,x_m,y_m\n7,1,2\n"), 0,
               "rows without epochs", "points.csv");
  const auto unheard = read_with(kStops, "points.csv", "epoch,x_m,y_m\n7,1,2\n12,1,2\n").value();
  ASSERT_EQ(unheard.warnings.size(), 1u);
  EXPECT_THAT(unheard.warnings[0], HasSubstr("points.csv:3"));
}

TEST(RunDistances, StandForTimesWhereTheSpeedIsConstant) {
  const std::string tof = "time_s,beacon,distance_m\n1,B0,30\n2,B1,\n3,B1,-1\n4,B1,15\n";
  const auto log = read_with(tof, "", "", {.constant_speed_mps = 3e8}).value();
  ASSERT_EQ(log.arrivals.size(), 2u);
  EXPECT_DOUBLE_EQ(log.arrivals[0].tof_s, 1e-7);
  EXPECT_DOUBLE_EQ(log.arrivals[1].tof_s, 5e-8);
  EXPECT_EQ(log.rejected.size(), 2u);
  EXPECT_EQ(log.arrivals[1].line, 5);
  Timing two_way;
  two_way.ranging = Ranging::kTwoWay;
  two_way.turnaround_s = 1e-3;
  EXPECT_DOUBLE_EQ(read_with(tof, "", "", {.constant_speed_mps = 3e8}, two_way).value().arrivals[0].tof_s,
                   2e-7 + 1e-3);
  // A quote makes the whole go the general way, which must agree.
  EXPECT_DOUBLE_EQ(read_with("time_s,beacon,distance_m\n1,\"B0\",30\n", "", "", {.constant_speed_mps = 3e8})
                       .value()
                       .arrivals[0]
                       .tof_s,
                   1e-7);
  expect_error(read_with(tof, "", ""), 1, "constant", "tof.csv");
  // If both are present, the time is the measured one.
  EXPECT_DOUBLE_EQ(
      read_with("time_s,beacon,tof_s,distance_m\n1,B0,0.5,30\n", "", "", {.constant_speed_mps = 3e8})
          .value()
          .arrivals[0]
          .tof_s,
      0.5);
}

}  // namespace run_points_test
}  // namespace octant::io
