// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace octant::survey {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

DeploymentBeacon beacon(const char* name, double x_m, double y_m, double sigma_m, BeaconStatus status) {
  DeploymentBeacon b;
  b.name = name;
  b.position_m = {x_m, y_m, 2.5};
  b.covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  b.status = status;
  return b;
}

ReportInput small_site() {
  ReportInput input;
  Deployment& d = input.plan.deployment;
  d.site = "hall";
  d.created = "2026-01-01T00:00:00Z";
  d.statistics.converged = true;
  d.beacons = {beacon("B0", 0, 0, 0, BeaconStatus::kControlPoint), beacon("B1", 10, 0, 0.002, BeaconStatus::kCalibrated),
               beacon("B2", 10, 8, 0.001, BeaconStatus::kCalibrated)};
  d.validity_area_m = {{1, 1}, {9, 1}, {9, 7}};
  input.plan.tracks = {{false, {{2, 2}, {3, 3}}}, {true, {{4, 4}, {5, 5}, {6, 5}}}};
  return input;
}

TEST(Report, IsOneClosedPage) {
  const std::string html = report_html(small_site());
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  EXPECT_THAT(html, Not(HasSubstr("href=")));
  EXPECT_THAT(html, HasSubstr("prefers-color-scheme"));
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

TEST(Report, EscapesWhatPeopleWrote) {
  ReportInput input = small_site();
  const std::string evil = "<img src=x onerror=alert(1)>&\"'";
  input.plan.deployment.site = input.plan.deployment.beacons[1].name = input.plan.deployment.program_command = evil;
  input.plan.deployment.datum.description = evil;
  input.plan.deployment.inputs = {{evil, evil}};
  input.warnings = {evil};
  input.weak = {{evil, evil, 0.001}};
  input.left_out = {{evil, 3}};
  input.evaluation = Evaluation{};
  input.evaluation->gates = {{evil, 1, 2, false}};
  EXPECT_THAT(report_html(input), Not(HasSubstr("<img")));
  EXPECT_EQ(escape_xml("a<b>&\"'\x01"), "a&lt;b&gt;&amp;&quot;&#39; ");
}

TEST(Report, VerdictFollowsTheTolerance) {
  ReportInput input = small_site();
  EXPECT_TRUE(verdict(input).good);
  input.plan.deployment.tolerance.beacon_m = 0.0048;  // 2.45 x 2 mm = 4.9 mm
  EXPECT_FALSE(verdict(input).good);
  EXPECT_THAT(verdict(input).sentence, HasSubstr("outside the tolerance of 4.8 mm"));
  input.plan.deployment.tolerance.beacon_m = 0.005;
  EXPECT_TRUE(verdict(input).good);
  input.evaluation = Evaluation{};
  input.evaluation->matched = 3;
  input.evaluation->gates = {{"fix_m", 0.01, 0.02, false}};
  EXPECT_FALSE(verdict(input).good);
  input.evaluation.reset();
  input.plan.deployment.beacons[2].status = BeaconStatus::kUndetermined;
  EXPECT_FALSE(verdict(input).good);
  EXPECT_THAT(verdict(input).sentence, HasSubstr("1 could not be determined"));
}

TEST(SitePlan, StatesTheExaggeration) {
  const ReportInput input = small_site();
  // 5 % of a plan of 11 m is 0.56 m; the largest ellipse is 6.9 mm: 80 times, rounded down to 50.
  EXPECT_DOUBLE_EQ(ellipse_exaggeration(input.plan.deployment, 11.2), 50.0);
  EXPECT_THAT(site_plan_svg(input.plan), HasSubstr("drawn 50 times"));
  EXPECT_DOUBLE_EQ(ellipse_exaggeration(input.plan.deployment, 0.01), 1.0);
}

TEST(SitePlan, EllipseHasTheAxesOfTheCovariance) {
  PlanInput plan = small_site().plan;
  // 45 degrees, 2 mm along, 1 mm across; the SVG's y axis points down, so the turn is negative.
  const Eigen::Rotation2Dd turn(M_PI / 4);
  const Eigen::Matrix2d R = turn.toRotationMatrix();
  plan.deployment.beacons[1].covariance_m2.topLeftCorner<2, 2>() = R * Eigen::Vector2d(4e-6, 1e-6).asDiagonal() * R.transpose();
  plan.deployment.beacons.pop_back();
  const std::string svg = site_plan_svg(plan);
  double rx = 0, ry = 0, degrees = 0, x = 0, y = 0;
  const std::size_t at = svg.find("<ellipse");
  ASSERT_NE(at, std::string::npos);
  ASSERT_EQ(std::sscanf(svg.c_str() + at, "<ellipse class='ellipse' cx='%lf' cy='%lf' rx='%lf' ry='%lf' transform='rotate(%lf", &x, &y, &rx, &ry,
                        &degrees), 5);
  EXPECT_NEAR(rx / ry, 2.0, 0.01);
  EXPECT_NEAR(std::abs(std::remainder(degrees + 45, 180)), 0.0, 0.1);
}

TEST(SitePlan, SurvivesOddSites) {
  EXPECT_THAT(site_plan_svg({}), HasSubstr("</svg>"));
  PlanInput one;
  one.deployment.beacons = {beacon("far", 5.0e5, 4.0e6, 0.01, BeaconStatus::kCalibrated)};
  EXPECT_THAT(site_plan_svg(one), HasSubstr("far"));
  EXPECT_LT(site_plan_svg(one).size(), 20'000u);
  one.deployment.beacons.push_back(beacon("lost", std::numeric_limits<double>::quiet_NaN(), 0, 0.01, BeaconStatus::kUndetermined));
  const std::string svg = site_plan_svg(one);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("lost")));
  PlanInput drive;
  drive.tracks = {{true, std::vector<Eigen::Vector2d>(200'000, Eigen::Vector2d(1, 2))}};
  EXPECT_LT(site_plan_svg(drive).size(), 100'000u);
}

}  // namespace
}  // namespace octant::survey
