// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "io/export/exported.h"
#include "io/run/tum.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace fixes_file_test {

using test::expect_error;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kHead =
    "time_s,vehicle,status,x_m,y_m,z_m,heading_rad,sigma_x_m,sigma_y_m,sigma_heading_rad,protection_level_m,"
    "arrivals_used,arrivals_rejected\n";

Result<ExportedFixes> read(const std::string& text) {
  const TemporaryFolder folder;
  return read_fixes(folder.write("fixes.csv", text));
}

Fix some_fix(std::size_t vehicles) {
  Fix fix;
  fix.time_s = test::some_number();
  fix.vehicle = VehicleId(*rc::gen::inRange<std::size_t>(0, vehicles));
  fix.status =
      *rc::gen::element(FixStatus::kOk, FixStatus::kOk, FixStatus::kTooFewArrivals, FixStatus::kPoorGeometry,
                        FixStatus::kAmbiguous, FixStatus::kNoConsensus, FixStatus::kNotConverged);
  fix.arrivals_used = *rc::gen::inRange(0, 1000);
  fix.arrivals_rejected = *rc::gen::inRange(0, 1000);
  if (!fix.ok()) return fix;
  fix.T_map_vehicle = Pose::planar(test::some_number(), test::some_number(), 6 * test::some_fraction() - 3);
  fix.T_map_vehicle.translation_m.z() = test::some_number();
  fix.covariance = PoseCovariance::Zero(3, 3);
  for (int i = 0; i < 3; ++i) fix.covariance(i, i) = test::some_fraction() + 1e-9;
  fix.protection_level_m = test::some_positive();
  return fix;
}

TEST(FixesFile, ReadsBackWhatLocalizeWrites) {
  EXPECT_TRUE(rc::check("read(write(x)) == x, vehicles by their names", [] {
    NameTable names;
    for (std::size_t v = 0; v < 3; ++v) names.vehicles.push_back(test::some_name(v));
    std::vector<Fix> fixes;
    for (int i = *rc::gen::inRange(0, 8); i > 0; --i) fixes.push_back(some_fix(3));
    const auto back = read(fixes_to_csv(fixes, names));
    RC_ASSERT(back.has_value());
    RC_ASSERT(back->fixes.size() == fixes.size());
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      const Fix &a = fixes[i], &b = back->fixes[i];
      RC_ASSERT(a.time_s == b.time_s && a.status == b.status);
      RC_ASSERT(back->names.vehicles.at(b.vehicle.index()) == names.vehicles.at(a.vehicle.index()));
      RC_ASSERT(a.arrivals_used == b.arrivals_used && a.arrivals_rejected == b.arrivals_rejected);
      RC_ASSERT(a.T_map_vehicle.translation_m == b.T_map_vehicle.translation_m);
      RC_ASSERT(std::abs(a.T_map_vehicle.heading_rad() - b.T_map_vehicle.heading_rad()) < 1e-12);
      RC_ASSERT(a.protection_level_m == b.protection_level_m);
      for (int k = 0; a.ok() && k < 3; ++k)
        RC_ASSERT(std::abs(a.covariance(k, k) / b.covariance(k, k) - 1) < 1e-12);
    }
  }));
}

TEST(FixesFile, AFixWithoutSigmasHasNone) {
  const auto fixes = read(kHead + "1,robot,ok,1,2,3,0.5,,,,,,\n").value_or(ExportedFixes{});
  ASSERT_EQ(fixes.fixes.size(), 0U) << "a count that is empty is an error";
  const auto plain = read(
      "time_s,status,x_m,y_m,z_m,heading_rad,sigma_x_m,sigma_y_m,sigma_heading_rad,"
      "protection_level_m\n1,ok,1,2,3,0.5,,,,\n");
  ASSERT_TRUE(plain) << plain.error().message();
  const Fix& fix = plain->fixes.at(0);
  EXPECT_TRUE(fix.covariance.isZero(0.0));
  EXPECT_EQ(fix.protection_level_m, 0.0);
  EXPECT_FALSE(fix.vehicle.valid());
  EXPECT_EQ(fix.T_map_vehicle.translation_m, Eigen::Vector3d(1, 2, 3));
}

TEST(FixesFile, FaultsAreNamedAtTheirCells) {
  expect_error(read(kHead + "1,robot,ok,1,,3,0.5,,,,,1,0\n"), 2, "a fix that is ok without a pose",
               "fixes.csv");
  EXPECT_EQ(read(kHead + "1,robot,ok,1,,3,0.5,,,,,1,0\n").error().column, 14);
  EXPECT_TRUE(read(kHead + "1,robot,ambiguous,,,,,,,,,1,0\n")) << "without a fix there is no pose";
  expect_error(read(kHead + "1,robot,good,1,2,3,0.5,,,,,1,0\n"), 2, "'good'");
  expect_error(read(kHead + "x,robot,ok,1,2,3,0.5,,,,,1,0\n"), 2, "time_s is 'x'");
  expect_error(read(kHead + "1,robot,ok,1,2,3,0.5,,,,,1.5,0\n"), 2, "arrivals_used");
  expect_error(read("time_s,status,x_m\n1,ok,1\n"), 1, "are missing");
}

TEST(FixesFile, CountsBeyondAnyRecordingAreBounded) {
  const auto fixes = read(kHead + "1,robot,ok,1,2,3,0.5,,,,,9000000000,-7\n");
  ASSERT_TRUE(fixes);
  EXPECT_EQ(fixes->fixes[0].arrivals_used, 1 << 30);
  EXPECT_EQ(fixes->fixes[0].arrivals_rejected, 0);
}

TEST(FixesFile, ATrajectoryIsToldByItsHead) {
  for (const char* head : {"", "# time_s x y z qx qy qz qw\n", "\xEF\xBB\xBF# of the robot\n"}) {
    const auto fixes = read(std::string(head) + "1.5 1 2 3 0 0 0 1\n2.5 4 5 6 0 0 0 1\n");
    ASSERT_TRUE(fixes) << fixes.error().message();
    ASSERT_EQ(fixes->fixes.size(), 2U);
    EXPECT_EQ(fixes->fixes[1].time_s, 2.5);
    EXPECT_TRUE(fixes->fixes[1].ok());
    EXPECT_EQ(fixes->fixes[1].T_map_vehicle.translation_m, Eigen::Vector3d(4, 5, 6));
    EXPECT_EQ(fixes->fixes[1].covariance.rows(), 0) << "nothing is known of its accuracy";
  }
  const auto none = read("time_s\n1\n");
  EXPECT_FALSE(none);
  const TemporaryFolder folder;
  expect_error(read_fixes(folder.path("none")), 0, "No such file", "none");
}

}  // namespace fixes_file_test
}  // namespace octant::io
