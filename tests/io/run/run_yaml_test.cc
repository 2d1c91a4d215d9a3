// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "io/run/run_folder.h"
#include "io/tof/run_parts.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace run_yaml_test {

using test::expect_error;
using test::maybe;
using test::some_fraction;
using test::some_positive;
using testing::ElementsAre;
using testing::HasSubstr;

struct Read {
  Result<RunHeader> header;
  MeasurementLog log;
};
Read read(const std::string& text) {
  Read out;
  out.header = parse_run_yaml(text, "run.yaml", out.log);
  return out;
}

PoseAccuracy some_accuracy() {
  PoseAccuracy a;
  a.position_sigma_m = some_positive();
  a.heading_known = *rc::gen::arbitrary<bool>();
  if (a.heading_known) a.heading_sigma_rad = some_positive();
  a.attitude_sigma_rad = some_positive();
  a.max_gap_s = some_positive();
  return a;
}

bool same(const PoseAccuracy& a, const PoseAccuracy& b, bool gap) {
  return a.position_sigma_m == b.position_sigma_m && a.heading_known == b.heading_known &&
         (!a.heading_known || a.heading_sigma_rad == b.heading_sigma_rad) &&
         a.attitude_sigma_rad == b.attitude_sigma_rad && (!gap || a.max_gap_s == b.max_gap_s);
}

TEST(RunYaml, ReadsBackWhatItWrote) {
  EXPECT_TRUE(rc::check("read(write(x)) == x", [] {
    MeasurementLog log;
    const NameTable names{
        .beacons = {}, .vehicles = {test::some_name(0), test::some_name(1)}, .receivers = {}};
    if (*rc::gen::arbitrary<bool>()) log.vehicle = VehicleId(1);
    log.temperature_degC = maybe(200 * some_fraction() - 100);
    log.relative_humidity = maybe(some_fraction());
    log.pressure_pa = maybe(1e4 + 1e5 * some_fraction());
    log.poses.resize(*rc::gen::inRange<std::size_t>(0, 2));
    log.truth.resize(*rc::gen::inRange<std::size_t>(0, 2));
    log.odometry.resize(*rc::gen::inRange<std::size_t>(0, 2));
    log.pose_accuracy = some_accuracy(), log.truth_accuracy = some_accuracy();
    log.odometry_accuracy = {some_positive(), some_positive(), some_positive(), some_positive(),
                             some_positive()};
    const Read back = read(run_to_yaml(log, names));
    RC_ASSERT(back.header.has_value());
    RC_ASSERT(back.log.warnings.empty());
    RC_ASSERT(back.header->vehicle == (log.vehicle.valid() ? names.vehicles[1] : ""));
    RC_ASSERT(back.log.temperature_degC == log.temperature_degC);
    RC_ASSERT(back.log.relative_humidity == log.relative_humidity);
    RC_ASSERT(back.log.pressure_pa == log.pressure_pa);
    if (!log.poses.empty()) RC_ASSERT(same(back.log.pose_accuracy, log.pose_accuracy, true));
    if (!log.truth.empty()) RC_ASSERT(same(back.log.truth_accuracy, log.truth_accuracy, false));
    const OdometryAccuracy &a = back.log.odometry_accuracy, &b = log.odometry_accuracy;
    if (!log.odometry.empty())
      RC_ASSERT(a.distance_sigma_m_per_sqrt_m == b.distance_sigma_m_per_sqrt_m &&
                a.heading_sigma_rad_per_sqrt_m == b.heading_sigma_rad_per_sqrt_m &&
                a.heading_sigma_per_rad == b.heading_sigma_per_rad && a.floor_m == b.floor_m &&
                a.floor_rad == b.floor_rad);
  }));
}

TEST(RunYaml, WhatIsLeftOutKeepsItsDefault) {
  const Read r = read("octant_run: 1\nposes:\nodometry: {floor_m: 0.5}\n");
  ASSERT_TRUE(r.header);
  EXPECT_EQ(r.header->vehicle, "");
  EXPECT_TRUE(std::isinf(r.header->range_max_m));
  EXPECT_EQ(r.log.temperature_degC, std::nullopt);
  EXPECT_EQ(r.log.pose_accuracy.position_sigma_m, PoseAccuracy{}.position_sigma_m);
  EXPECT_EQ(r.log.odometry_accuracy.floor_m, 0.5);
  EXPECT_EQ(r.log.odometry_accuracy.floor_rad, OdometryAccuracy{}.floor_rad);
  EXPECT_EQ(read("octant_run: 1\nrange_max_m: 8\n").header->range_max_m, 8.0);
}

TEST(RunYaml, AttitudesAreAsWellKnownAsTheHeadingUnlessStated) {
  EXPECT_EQ(read("octant_run: 1\nposes: {heading_sigma_rad: 0.2}\n").log.pose_accuracy.attitude_sigma_rad,
            0.2);
  EXPECT_EQ(read("octant_run: 1\nposes: {heading_sigma_rad: 0.2, attitude_sigma_rad: 0.3}\n")
                .log.pose_accuracy.attitude_sigma_rad,
            0.3);
  EXPECT_EQ(read("octant_run: 1\ntruth: {position_sigma_m: 0.1}\n").log.truth_accuracy.attitude_sigma_rad,
            0.0)
      << "a reference is exact where nothing is said";
}

TEST(RunYaml, AHeadingIsKnownOrItIsNot) {
  const Read r = read("octant_run: 1\nposes: {heading: unknown}\n");
  ASSERT_TRUE(r.header);
  EXPECT_FALSE(r.log.pose_accuracy.heading_known);
  expect_error(read("octant_run: 1\nposes: {heading: unknown, heading_sigma_rad: 0.1}\n").header, 2,
               "poses has both heading: unknown and heading_sigma_rad", "run.yaml");
  expect_error(read("octant_run: 1\nposes: {heading: 0.5}\n").header, 2, "poses.heading is '0.5'");
}

TEST(RunYaml, FaultsAreNamedWithTheirLine) {
  expect_error(read("a: 1\n").header, 1, "'octant_run' is missing", "run.yaml");
  expect_error(read("octant_run: 1\ntemperature_degC: 293\n").header, 2, "20 degC are 293 K");
  expect_error(read("octant_run: 1\nrelative_humidity: 50\n").header, 2, "50 % is 0.5");
  expect_error(read("octant_run: 1\npressure_pa: 1013\n").header, 2, "1013 hPa are 101300");
  expect_error(read("octant_run: 1\nrange_max_m: 0\n").header, 2, "a positive number");
  expect_error(read("octant_run: 1\nodometry:\n  floor_m: -1\n").header, 3, "odometry.floor_m is '-1'");
  expect_error(read("octant_run: 1\nposes: 3\n").header, 2, "poses is '3'; expected a mapping");
}

TEST(RunYaml, KeysThatNobodyKnowsAreWarnings) {
  const Read r = read("octant_run: 1\ntemperature: 20\ntruth: {max_gap_s: 3}\n");
  ASSERT_TRUE(r.header);
  EXPECT_THAT(r.log.warnings, ElementsAre(HasSubstr("run.yaml:3: unknown key 'truth.max_gap_s'"),
                                          HasSubstr("run.yaml:2: unknown key 'temperature'")));
}

TEST(RunYaml, TheOdometrysAccuracyIsReadFromARunOrAFile) {
  const test::TemporaryFolder folder;
  const std::string file =
      folder.write("run/run.yaml", "octant_run: 1\nodometry: {floor_rad: 0.25}\nzebra: 1\n");
  for (const std::string& path : {file, folder.path("run")}) {
    std::vector<std::string> warnings;
    const auto accuracy = read_odometry_accuracy(path, warnings);
    ASSERT_TRUE(accuracy) << accuracy.error().message();
    EXPECT_EQ(accuracy->floor_rad, 0.25);
    EXPECT_THAT(warnings, ElementsAre(HasSubstr("zebra")));
  }
  std::vector<std::string> warnings;
  expect_error(read_odometry_accuracy(folder.write("b.yaml", "octant_run: 1\n"), warnings), 0,
               "nothing is said of the odometry", "b.yaml");
  expect_error(read_odometry_accuracy(folder.path("none"), warnings), 0, "No such file", "none");
}

}  // namespace run_yaml_test
}  // namespace octant::io
