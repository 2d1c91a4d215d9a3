// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/error_readings.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace octant::test {
namespace {

using ::testing::HasSubstr;

std::vector<MeasurementLog> driven() {
  std::vector<MeasurementLog> runs(1);
  runs[0].path = "run";
  runs[0].odometry = {{.time_s = 1.0, .dx_m = 0.5, .dy_m = 0.1, .dheading_rad = 0.2}};
  return runs;
}

TEST(OdometryOfOtherScale, IsReadAsTheVehicleWent) {
  const std::vector<MeasurementLog> runs = driven();
  const Site site;
  const auto families = calib::odometry_of_other_scale(site, runs);
  ASSERT_EQ(families.size(), 2U);
  const calib::Reading way = families[0].reading(0.04), turns = families[1].reading(-0.1);
  EXPECT_THAT(way.what.found, HasSubstr("its way is 4 % too long"));
  EXPECT_THAT(way.what.remedy, HasSubstr("multiply dx_m and dy_m by 0.9615"));
  EXPECT_THAT(turns.what.found, HasSubstr("its turns are 10 % too small"));
  EXPECT_TRUE(way.is_of_whole && turns.is_of_whole) << "before rows are summed up";
  MeasurementLog run = runs[0];
  run.odometry[0].way_m = 0.52;
  way.log(0, run);
  turns.log(0, run);
  EXPECT_NEAR(run.odometry[0].dx_m, 0.5 / 1.04, 1e-12);
  EXPECT_NEAR(run.odometry[0].dy_m, 0.1 / 1.04, 1e-12);
  EXPECT_NEAR(run.odometry[0].way_m, 0.5, 1e-12);
  EXPECT_NEAR(run.odometry[0].dheading_rad, 0.2 / 0.9, 1e-12);
}

TEST(WithCommonErrors, TakesThemBackFromTheRunThatHasThem) {
  std::vector<MeasurementLog> runs(2);
  for (MeasurementLog& run : runs)
    for (const double time_s : {10.0, 15.0, 20.0}) run.arrivals.push_back({.time_s = time_s, .tof_s = 0.02});
  const Site site;
  using Kind = calib::CommonError::Kind;
  const auto families =
      calib::with_common_errors({{.kind = Kind::kTurns, .size = 0.1},
                                 {.kind = Kind::kSpeed, .run = 1, .size = 0.01},
                                 {.kind = Kind::kDrift, .run = 1, .size = -1e-4},
                                 {.kind = Kind::kJump, .run = 1, .time_s = 15.0, .size = 2e-5}},
                                site, runs);
  ASSERT_EQ(families.size(), 3U) << "odometry's has a family of its own";
  EXPECT_LT(families[2].least, 2e-5);
  EXPECT_GT(families[2].most, 1e-4) << "what all bend to comes out too small";
  const auto read = [&](std::size_t family, double size, std::size_t run) {
    MeasurementLog log = runs[run];
    families[family].reading(size).log(run, log);
    return std::vector<double>{log.arrivals[0].tof_s, log.arrivals[1].tof_s, log.arrivals[2].tof_s};
  };
  using ::testing::DoubleNear;
  using ::testing::ElementsAre;
  const auto near = [](double value) { return DoubleNear(value, 1e-15); };
  EXPECT_THAT(read(0, 0.02, 1), ElementsAre(near(0.02 / 1.01), near(0.02), near(0.02 / 0.99)));
  EXPECT_THAT(read(1, 4e-4, 1), ElementsAre(near(0.0202), near(0.02), near(0.0198)));
  EXPECT_THAT(read(2, 3e-5, 1), ElementsAre(near(0.02), near(0.01997), near(0.01997)));
  EXPECT_THAT(read(2, 3e-5, 0), ElementsAre(near(0.02), near(0.02), near(0.02))) << "another recording";
}

TEST(OdometryOfOtherScale, IsNoneWithoutOdometryOrInSpace) {
  std::vector<MeasurementLog> runs(1);
  EXPECT_TRUE(calib::odometry_of_other_scale(Site{}, runs).empty());
  runs = driven();
  runs[0].odometry[0].dz_m = 0.1;
  EXPECT_TRUE(calib::odometry_of_other_scale(Site{}, runs).empty());
}

}  // namespace
}  // namespace octant::test
