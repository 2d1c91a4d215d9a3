// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "io/run/run_folder.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace run_csv_test {

struct File {
  std::string name, text;
};

Result<MeasurementLog> read(const std::vector<File>& files) {
  const NameTable names{.beacons = {"B0"}, .vehicles = {"drone"}, .receivers = {{"t0", VehicleId(0)}}};
  const test::TemporaryFolder folder;
  for (const File& file : files) folder.write("run/" + file.name, file.text);
  return read_run(folder.path("run"), names, Timing{});
}

TEST(RunCsv, RangesBetweenBeacons) {
  const NameTable names{.beacons = {"B0", "B1"}, .vehicles = {"drone"}, .receivers = {}};
  const test::TemporaryFolder folder;
  EXPECT_TRUE(read_beacon_flights(folder.path(), names, 0).value().flights.empty());
  folder.write("beacon_tof.csv",
               "time_s,beacon_from,beacon_to,tof_s,level_dbm\n1,B0,B1,2e-8,-70\n2,B1,B0,nan,\n3,B1,B0,-1,\n"
               "4,B0,B1,1e300,\n");
  const BeaconFlightLog log = read_beacon_flights(folder.path(), names, 3).value();
  ASSERT_EQ(log.flights.size(), 1U);
  EXPECT_EQ(log.flights[0].tof_s, 2e-8);
  EXPECT_EQ(log.flights[0].to, BeaconId(1));
  EXPECT_EQ(log.flights[0].run, 3U);
  EXPECT_EQ(log.sha256.size(), 64U);
  ASSERT_EQ(log.warnings.size(), 1U);
  EXPECT_THAT(log.warnings[0], testing::HasSubstr("3 rows left out"));
  const std::string header = "time_s,beacon_from,beacon_to,tof_s\n";
  folder.write("beacon_tof.csv", header + "1,B0,B2,2e-8\n");
  test::expect_error(read_beacon_flights(folder.path(), names, 0), 2, "B2", "beacon_tof.csv");
  EXPECT_THAT(read_beacon_flights(folder.path(), names, 0).error().message(),
              testing::Not(testing::HasSubstr("octant convert")));  // which does not read this table
  folder.write("beacon_tof.csv", header + "1,B0,B0,2e-8\n");
  test::expect_error(read_beacon_flights(folder.path(), names, 0), 2, "ranges to itself", "beacon_tof.csv");
}

// By rows with a quaternion, or by where odometry has the vehicle in a frame of its own.
TEST(RunCsv, OdometryInSpace) {
  const File tof{"tof.csv", "time_s,beacon,tof_s\n1,B0,0.01\n"};
  const double h = std::sqrt(0.5);
  const std::string rows = fmt::format(
      "time_s,dx_m,dy_m,dz_m,qx,qy,qz,qw\n1,0,0,0,0,0,0,1\n2,0.1,0.2,0.3,0,{0},0,{0}\n"
      "3,0.5,0,0,0,0,0,2\n",
      h);
  const auto log = read({tof, {"odometry.csv", rows}}).value();
  ASSERT_EQ(log.odometry.size(), 3U);
  EXPECT_TRUE(log.odometry[0].is_zero());
  EXPECT_EQ(log.odometry[1].dz_m, 0.3);
  EXPECT_NEAR(log.odometry[1].turn_y_rad, M_PI / 2, 1e-12);
  EXPECT_TRUE(log.odometry[2].is_planar());
  // The last step is forward, which is down by then.
  const std::string track =
      fmt::format("1 5 5 5 0 0 0 1\n2 5.1 5.2 5.3 0 {0} 0 {0}\n3 5.1 5.2 4.8 0 {0} 0 {0}\n", h);
  const auto same = read({tof, {"odometry.tum", track}}).value();
  ASSERT_EQ(same.odometry.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(same.odometry[i].time_s, log.odometry[i].time_s);
    EXPECT_EQ(same.odometry[i].vehicle, log.odometry[i].vehicle);
    EXPECT_LT((same.odometry[i].pose().translation_m - log.odometry[i].pose().translation_m).norm(), 1e-12);
    EXPECT_LT((same.odometry[i].turn_rad() - log.odometry[i].turn_rad()).norm(), 1e-7);
  }
  EXPECT_EQ(same.sha256.size(), 2U);
  test::expect_error(read({tof, {"odometry.csv", rows}, {"odometry.tum", track}}), 0,
                     "odometry.csv is there too", "odometry.tum");
}

}  // namespace run_csv_test
}  // namespace octant::io
