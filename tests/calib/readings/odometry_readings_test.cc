// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/odometry_readings.h"

#include <cmath>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/readings/readings.h"
#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace odometry_readings_test {

using ::testing::HasSubstr;

// The hypothesis for each odometry convention restores the original rows.
TEST(OtherOdometry, ReadsEachConventionBack) {
  MeasurementLog log;
  for (int i = 0; i < 5; ++i)
    log.odometry.push_back({0.1 * i, 0.02 + 0.001 * i, 0.003, -0.01 * i, VehicleId(0)});
  const auto readings = calib::other_odometry({log});
  ASSERT_EQ(readings.size(), 7U);
  const std::tuple<const char*, double, double, double> written[] = {
      {"turns count clockwise", 1.0, 1.0, -1.0},
      {"way backward", -1.0, 1.0, 1.0},
      {"y counts to the right", 1.0, -1.0, -1.0},
      {"backward and turns", -1.0, 1.0, -1.0},
      {"degrees", 1.0, 1.0, 180.0 / M_PI},
      {"millimetres", 1e3, 1e3, 1.0},
      {"centimetres", 1e2, 1e2, 1.0}};
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const auto& [words, way, side, turn] = written[k];
    EXPECT_NE(readings[k].what.found.find(words), std::string::npos) << readings[k].what.found;
    EXPECT_TRUE(readings[k].is_of_whole) << "rows of another convention do not sum up";
    MeasurementLog other = log;
    for (OdometryStep& step : other.odometry) {
      step.dx_m *= way;
      step.dy_m *= side;
      step.dheading_rad *= turn;
    }
    readings[k].log(0, other);
    for (std::size_t i = 0; i < log.odometry.size(); ++i) {
      EXPECT_NEAR(other.odometry[i].dx_m, log.odometry[i].dx_m, 1e-15) << words;
      EXPECT_NEAR(other.odometry[i].dy_m, log.odometry[i].dy_m, 1e-15) << words;
      EXPECT_NEAR(other.odometry[i].dheading_rad, log.odometry[i].dheading_rad, 1e-15) << words;
    }
  }
}

TEST(OtherOdometry, IsNoneWithoutOdometryOrInSpace) {
  MeasurementLog log;
  EXPECT_TRUE(calib::other_odometry({log}).empty());
  OdometryStep up;
  up.dz_m = 0.1;
  log.odometry = {up};
  EXPECT_TRUE(calib::other_odometry({log}).empty());
}

// The search has a limit of time, so what has no free parameter and costs one trial comes before scales and
// lags, which cost dozens of trials each.
TEST(OtherOdometry, IsExaminedBeforeScalesAndLags) {
  World world = must(simulate(drive_scenario(60.0), 5));
  for (OdometryStep& step : world.run.odometry) step.dheading_rad = -step.dheading_rad;
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem, {.diagnosis_s = 0.0});
  constexpr int kMostIterations = 1500;
  int iterations = 0;
  calib::SolveOptions limited;
  limited.on_progress = [&](const calib::Progress&) { return ++iterations < kMostIterations; };
  const auto found = calib::find_misreadings(problem, solution, limited);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].found, HasSubstr("clockwise"));
}

std::vector<MeasurementLog> driven() {
  std::vector<MeasurementLog> runs(1);
  runs[0].path = "run";
  runs[0].odometry = {{.time_s = 1.0, .dx_m = 0.5, .dy_m = 0.1, .dheading_rad = 0.2}};
  return runs;
}

TEST(OdometryStampedLate, IsReadByTheClockOfTheArrivals) {
  const std::vector<MeasurementLog> runs = driven();
  const auto families = calib::odometry_stamped_late(runs);
  ASSERT_EQ(families.size(), 1U);
  const calib::Reading late = families[0].reading(0.25);
  EXPECT_THAT(late.what.found, HasSubstr("0.25 s late"));
  MeasurementLog run = runs[0];
  late.log(0, run);
  EXPECT_EQ(run.odometry[0].time_s, 0.75);
}

TEST(OdometryStampedLate, IsNoneWithoutOdometryOrInSpace) {
  std::vector<MeasurementLog> runs(1);
  EXPECT_TRUE(calib::odometry_stamped_late(runs).empty());
  runs = driven();
  runs[0].odometry[0].dz_m = 0.1;
  EXPECT_TRUE(calib::odometry_stamped_late(runs).empty());
}

}  // namespace odometry_readings_test
}  // namespace octant::test
