// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "survey/report/report_sections.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_beacons_test {

using ::testing::HasSubstr;

ReportTable table_of(const ReportInput& input, const std::string& id) {
  const auto section = beacons_section(input);
  if (section)
    for (const ReportBlock& block : section->blocks)
      if (const auto* table = std::get_if<ReportTable>(&block); table != nullptr && table->id == id)
        return *table;
  ADD_FAILURE() << "no table " << id;
  return {};
}

std::size_t column_of(const ReportTable& table, const std::string& begins) {
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (table.columns[i].name.starts_with(begins)) return i;
  ADD_FAILURE() << "no column " << begins;
  return 0;
}

std::string cell(const ReportTable& table, std::size_t row, const std::string& column) {
  return table.rows.at(row).at(column_of(table, column)).text;
}

/// B1 with standard deviations along and across a direction in the plane.
ReportInput with_ellipse(double along_m, double across_m, double azimuth_rad) {
  ReportInput input = full_report();
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(azimuth_rad).toRotationMatrix();
  input.plan.deployment.beacons[1].covariance_m2.topLeftCorner<2, 2>() =
      R * Eigen::Vector2d(along_m * along_m, across_m * across_m).asDiagonal() * R.transpose();
  return input;
}

TEST(ReportBeacons, TheLongerHalfAxisIsThatOfTheLargestEigenvalue) {
  Random draws(20261125);
  for (int i = 0; i < 200; ++i) {
    DeploymentBeacon b;
    Eigen::Matrix3d root;
    for (int k = 0; k < 3; ++k) root.col(k) = draws.log_uniform(1e-4, 1e-1) * draws.normal3();
    b.covariance_m2 = root * root.transpose();
    const Eigen::Matrix2d flat = b.covariance_m2.topLeftCorner<2, 2>();
    const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(flat).eigenvalues()[1];
    // sqrt(-2 ln 0.05) = 2.44775: the constant has five digits.
    EXPECT_NEAR(radius95_m(b) / std::sqrt(-2 * std::log(0.05) * largest), 1.0, 3e-5);
  }
  EXPECT_EQ(radius95_m(DeploymentBeacon{}), 0.0);
}

TEST(ReportBeacons, EllipsesAreStatedByTheirAxesAndAzimuth) {
  for (double degrees = 0.0; degrees < 360.0; degrees += 7.0) {
    const ReportTable table = table_of(with_ellipse(0.004, 0.001, degrees * M_PI / 180), "reliability");
    EXPECT_EQ(table.rows[1][0].text, "B1");
    EXPECT_EQ(cell(table, 1, "95 % ellipse a"), "9.79") << "2.4477 x 4 mm";
    EXPECT_EQ(cell(table, 1, "b [mm]"), "2.45");
    // An axis has no sense: from -90 to 90 degrees.
    const double azimuth = std::stod(cell(table, 1, "azimuth"));
    EXPECT_NEAR(std::remainder(azimuth - degrees, 180.0), 0.0, 0.5) << degrees;
    EXPECT_LE(std::abs(azimuth), 90.0);
  }
  EXPECT_EQ(cell(table_of(full_report(), "reliability"), 0, "95 % ellipse a"), "-")
      << "a control point has none";
}

TEST(ReportBeacons, ExpandedUncertaintiesAreTwiceTheSigmasInTheColumnsUnit) {
  ReportInput input = full_report();
  input.plan.deployment.beacons[1].covariance_m2 = Eigen::Vector3d(4e-6, 9e-6, 16e-6).asDiagonal();
  ReportTable table = table_of(input, "beacon-table");
  EXPECT_EQ(cell(table, 1, "U x [mm]"), "4.00");
  EXPECT_EQ(cell(table, 1, "U y [mm]"), "6.00");
  EXPECT_EQ(cell(table, 1, "U z [mm]"), "8.00");
  EXPECT_EQ(cell(table, 0, "U x"), "fixed");
  EXPECT_EQ(cell(table, 1, "delay [µs]"), "100.000");
  EXPECT_EQ(cell(table, 1, "U delay"), "4.000");
  input.plan.deployment.beacons[2].covariance_m2(0, 0) = 1.0;  // a column in metres
  table = table_of(input, "beacon-table");
  EXPECT_EQ(cell(table, 2, "U x [m]"), "2.00");
  EXPECT_EQ(cell(table, 1, "U x [m]"), "0.00");
}

TEST(ReportBeacons, DelaysHaveColumnsOnlyWhereThereAreSome) {
  ReportInput input = full_report();
  for (auto& b : input.plan.deployment.beacons) b.delay_s = b.delay_sigma_s = 0.0;
  for (const auto& column : table_of(input, "beacon-table").columns)
    EXPECT_EQ(column.name.find("delay"), std::string::npos);
}

TEST(ReportBeacons, WhatIsNotDeterminedHasNoNumbersAndNotUnnoticed) {
  ReportInput input = full_report();
  input.plan.deployment.beacons[2].status = BeaconStatus::kUndetermined;
  input.plan.deployment.beacons[2].covariance_m2 *= 1e12;  // not even in the choice of the unit
  const ReportTable table = table_of(input, "beacon-table");
  for (const char* column : {"x [m]", "y [m]", "z [m]", "U x [mm]", "delay"})
    EXPECT_EQ(cell(table, 2, column), "-");
  EXPECT_EQ(table.rows[2].back().text, "undetermined");
  EXPECT_EQ(table.rows[2].back().tone, Tone::kBad);
}

TEST(ReportBeacons, WhoWasNotHeardHasNoReliability) {
  ReportInput input = full_report();
  input.beacons[1].used = 0;
  input.beacons.pop_back();  // nothing is known of B2
  EXPECT_EQ(table_of(input, "reliability").rows.size(), 1U);
  const ReportTable table = table_of(input, "beacon-table");
  EXPECT_EQ(cell(table, 1, "r"), "-");
  EXPECT_EQ(cell(table, 1, "arrivals"), "0");
  EXPECT_EQ(cell(table, 2, "arrivals"), "-");
  input.beacons[0].used = 0;
  const auto section = beacons_section(input);
  EXPECT_EQ(section->blocks.size(), 1U) << "no empty table";
}

TEST(ReportBeacons, OfVeryManyTheLeastWellKnownAreShown) {
  ReportInput input = full_report();
  auto& beacons = input.plan.deployment.beacons;
  beacons.clear();
  for (int i = 0; i < 1000; ++i)
    beacons.push_back(
        test_beacon("B" + std::to_string(i), i, 0, 1e-5 * ((i * 37) % 1000), BeaconStatus::kCalibrated));
  beacons[5].status = BeaconStatus::kUndetermined;
  const ReportTable table = table_of(input, "beacon-table");
  ASSERT_EQ(table.rows.size(), kMaxRows);
  EXPECT_EQ(table.rows[0][0].text, "B5") << "not known at all";
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    const int number = std::stoi(table.rows[i][0].text.substr(1));
    EXPECT_GE((number * 37) % 1000, 1000 - static_cast<int>(kMaxRows) - 1) << "one of the worst";
  }
  const auto section = beacons_section(input);
  const auto* words = std::get_if<ReportText>(&section->blocks.front());
  ASSERT_NE(words, nullptr);
  EXPECT_THAT(words->text, HasSubstr("400 of 1000 beacons that are known least well"));
}

TEST(ReportBeacons, ASlipOfTheTapeStandsOut) {
  ReportInput input = full_report();
  input.moved = {{"B1", {0.5, std::nullopt, -0.1}, 0.002, 0.1, 0.51},
                 {"B2", {0.03, 0.0, 0.0}, 0.002, 0.1, 0.03}};
  const ReportTable table = table_of(input, "moved");
  EXPECT_EQ(cell(table, 0, "dx [mm]"), "500.0");
  EXPECT_EQ(cell(table, 0, "dy [mm]"), "-") << "nothing was stated of it";
  EXPECT_EQ(cell(table, 0, "dz [mm]"), "-100.0");
  EXPECT_EQ(cell(table, 0, "stated within [mm]"), "100.0");
  EXPECT_EQ(table.rows[0][0].tone, Tone::kAttention) << "five times what was stated";
  EXPECT_EQ(table.rows[1][0].tone, Tone::kPlain);
}

TEST(ReportBeacons, WithoutAnyThereIsNothingToSay) {
  ReportInput input = full_report();
  input.plan.deployment.beacons.clear();
  EXPECT_FALSE(beacons_section(input));
  input = full_report();
  input.beacons.clear();
  for (auto& b : input.plan.deployment.beacons) b.status = BeaconStatus::kUndetermined;
  const auto section = beacons_section(input);
  ASSERT_EQ(section->blocks.size(), 1U);
  EXPECT_THAT(std::get<ReportText>(section->blocks[0]).text, HasSubstr("none of the 3 beacons"));
}

}  // namespace report_beacons_test
}  // namespace octant::survey
