// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/error_readings.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace octant::test {
namespace error_readings_test {

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

TEST(TakeBack, LeavesTheObservationsWithoutTheError) {
  MeasurementLog run;
  for (const double time_s : {10.0, 15.0, 20.0}) run.arrivals.push_back({.time_s = time_s, .tof_s = 0.02});
  const std::pair<double, double> span_s = calib::span_of(run.arrivals);
  using Kind = calib::CommonError::Kind;
  const auto without = [&](const calib::CommonError& error) {
    MeasurementLog log = run;
    calib::take_back(error, span_s, log);
    return std::vector<double>{log.arrivals[0].tof_s, log.arrivals[1].tof_s, log.arrivals[2].tof_s};
  };
  using ::testing::DoubleNear;
  using ::testing::ElementsAre;
  const auto near = [](double value) { return DoubleNear(value, 1e-15); };
  EXPECT_THAT(without({.kind = Kind::kSpeed, .size = 0.02}),
              ElementsAre(near(0.02 / 1.01), near(0.02), near(0.02 / 0.99)));
  EXPECT_THAT(without({.kind = Kind::kDrift, .size = 4e-4}),
              ElementsAre(near(0.0202), near(0.02), near(0.0198)));
  EXPECT_THAT(without({.kind = Kind::kJump, .time_s = 15.0, .size = 3e-5}),
              ElementsAre(near(0.02), near(0.01997), near(0.01997)));
}

TEST(OdometryOfOtherScale, IsNoneWithoutOdometryOrInSpace) {
  std::vector<MeasurementLog> runs(1);
  EXPECT_TRUE(calib::odometry_of_other_scale(Site{}, runs).empty());
  runs = driven();
  runs[0].odometry[0].dz_m = 0.1;
  EXPECT_TRUE(calib::odometry_of_other_scale(Site{}, runs).empty());
}

}  // namespace error_readings_test
}  // namespace octant::test
