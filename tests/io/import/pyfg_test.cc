// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/pyfg.h"

#include <numbers>

#include <fmt/format.h>

#include "tests/io/io_support.h"

namespace octant::io::test {
namespace pyfg_test {

using ::testing::Contains;
using ::testing::HasSubstr;

/// A quarter turn to the left after one metre, and two robots.
constexpr const char* kPlane =
    "VERTEX_SE2 10.0 A0 0 0 0\n"
    "VERTEX_SE2 10.5 A1 1 0 1.5707963267948966\n"
    "VERTEX_SE2 11.0 A2 1 2 1.5707963267948966\n"
    "VERTEX_SE2 10.0 B0 5 5 0\n"
    "VERTEX_XY L0 3 4\n"
    "VERTEX_XY L1 -3 4\n"
    "VERTEX_SE2:PRIOR 10.0 A0 0 0 0 0.01 0 0 0.01 0 0.04\n"
    "EDGE_SE2 10.0 A0 A1 1 0 1.5707963267948966 0.01 0 0 0.01 0 0.04\n"
    "EDGE_SE2 10.5 A1 A2 2 0 0 0.01 0 0 0.01 0 0.04\n"
    "EDGE_SE2 11.0 A2 A0 -2 1 -1.5 0.01 0 0 0.01 0 0.04\n"
    "EDGE_SE2_XY 10.0 A0 L0 3 4 0.01 0 0.01\n"
    "EDGE_RANGE 10.0 A0 L0 5 0.01\n"
    "EDGE_RANGE 10.5 A1 L1 5.7 0.01\n"
    "EDGE_RANGE 10.5 A1 B0 6.4 0.01\n"
    "EDGE_RANGE 10.0 B0 L0 2.2 0.01\n";

TEST(Pyfg, TheGraphOfARobotInThePlane) {
  const TemporaryFolder box;
  const std::string path = box.write("g.pyfg", kPlane);
  EXPECT_TRUE(is_pyfg(path));
  EXPECT_FALSE(is_pyfg(box.write("t.csv", "time,anchor\n")));
  auto log = read_pyfg(path);
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_EQ(run_files(*log, "run", {})->front().content, "time_s,beacon,distance_m\n10,L0,5\n10.5,L1,5.7\n");
  ASSERT_EQ(log->odometry.size(), 3U);
  ASSERT_EQ(log->truth.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(log->odometry[i].time_s, log->truth[i].time_s);
    EXPECT_LT(
        (log->odometry[i].T_map_vehicle.translation_m - log->truth[i].T_map_vehicle.translation_m).norm(),
        1e-12);
  }
  for (const char* what : {"1 loop closures", "1 priors", "1 poses of other robots",
                           "1 ranges between robots", "1 ranges of other robots"})
    EXPECT_THAT(log->warnings, Contains(HasSubstr(what)));
  const auto other = read_pyfg(path, "B");
  ASSERT_TRUE(other);
  EXPECT_EQ(other->arrivals.size(), 1U);
}

TEST(Pyfg, OdometryFollowsTheVerticesOnceEach) {
  const std::string vertices =
      "VERTEX_SE2 0 A0 0 0 0\nVERTEX_SE2 1 A1 1 0 0\nVERTEX_SE2 2 A2 2 0 0\nVERTEX_SE2 3 A3 3 0 0\n"
      "VERTEX_XY L0 1 1\nEDGE_RANGE 0 A0 L0 1.5 0.1\n";
  const auto edge = [](int i) { return fmt::format("EDGE_SE2 {0} A{0} A{1} 1 0 0 1 0 0 1 0 1\n", i, i + 1); };
  const TemporaryFolder box;
  const auto log = read_pyfg(box.write("g.pyfg", vertices + edge(2) + edge(0) + edge(0) + edge(1)));
  ASSERT_TRUE(log) << log.error().message();
  ASSERT_EQ(log->odometry.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(log->odometry[i].time_s, log->truth[i].time_s);
    EXPECT_EQ(log->odometry[i].T_map_vehicle.translation_m, log->truth[i].T_map_vehicle.translation_m);
  }
  EXPECT_THAT(log->warnings, Contains(HasSubstr("1 repeated edges")));
  const auto gap = read_pyfg(box.write("gap.pyfg", vertices + edge(0) + edge(2)));
  ASSERT_TRUE(gap) << gap.error().message();
  EXPECT_EQ(gap->odometry.size(), 4U);
  EXPECT_THAT(gap->warnings, Contains(HasSubstr("no edge from A1 to A2")));
}

TEST(Pyfg, AGraphInSpace) {
  const TemporaryFolder box;
  const auto log = read_pyfg(box.write(
      "g.pyfg",
      "VERTEX_SE3:QUAT 0.0 A0 0 0 1 0 0 0 1\n"
      "VERTEX_SE3:QUAT 1.0 A1 1 0 2 0 0 0.7071068 0.7071068\n"
      "VERTEX_XYZ L0 3 4 5\n"
      "EDGE_SE3:QUAT 0.0 A0 A1 1 0 1 0 0 0.7071068 0.7071068 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"
      "EDGE_RANGE 1.0 A1 L0 5.385 0.01\n"));
  ASSERT_TRUE(log) << log.error().message();
  ASSERT_EQ(log->odometry.size(), 2U);
  EXPECT_NEAR(log->odometry[1].T_map_vehicle.heading_rad(), std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(log->odometry[1].T_map_vehicle.rotation.norm(), 1.0, 1e-12);
  EXPECT_EQ(log->arrivals.size(), 1U);
}

TEST(Pyfg, FaultsAreNamed) {
  const TemporaryFolder box;
  expect_error(read_pyfg(box.write("a", "VERTEX_SE2 0 A0 0 0\n")), 1, "incomplete vertex");
  expect_error(read_pyfg(box.write("b", "VERTEX_SE2 0 A0 0 0 0\nEDGE_SE2 0 A0 A1 1 x 0\n")), 2,
               "incomplete edge");
  expect_error(read_pyfg(box.write("c", "EDGE_RANGE 0 A0 L0\n")), 1, "incomplete range");
  expect_error(read_pyfg(box.write("d", "VERTEX_SE3:QUAT 0 A0 0 0 0 0 0 0 0\n")), 1, "incomplete vertex");
  expect_error(read_pyfg(box.write("e", "VERTEX_SE2 0 A0 0 0 0\nVERTEX 1\n")), 2, "'VERTEX'");
}

}  // namespace pyfg_test
}  // namespace octant::io::test
