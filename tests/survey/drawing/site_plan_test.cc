// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/site_plan.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/drawing/palette.h"
#include "survey/drawing/plan_frame.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace site_plan_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(SitePlan, StatesTheExaggeration) {
  const ReportInput input = full_report();
  // 5 % of a plan of 11 m is 0.56 m; the largest ellipse is 6.9 mm: 80 times, rounded down to 50.
  EXPECT_DOUBLE_EQ(ellipse_exaggeration(input.plan.deployment, 11.2), 50.0);
  EXPECT_THAT(site_plan_svg(input.plan), HasSubstr("drawn 50 times"));
  EXPECT_DOUBLE_EQ(ellipse_exaggeration(input.plan.deployment, 0.01), 1.0);
}

TEST(SitePlan, EllipseHasTheAxesOfTheCovariance) {
  PlanInput plan = full_report().plan;
  // 45 degrees, 2 mm along, 1 mm across; the SVG's y axis points down, so the turn is negative.
  const Eigen::Rotation2Dd turn(M_PI / 4);
  const Eigen::Matrix2d R = turn.toRotationMatrix();
  plan.deployment.beacons[1].covariance_m2.topLeftCorner<2, 2>() =
      R * Eigen::Vector2d(4e-6, 1e-6).asDiagonal() * R.transpose();
  plan.deployment.beacons.pop_back();
  plan.maps.clear();
  const std::string svg = site_plan_svg(plan);
  double rx = 0, ry = 0, degrees = 0, x = 0, y = 0;
  const std::size_t at = svg.find("<ellipse");
  ASSERT_NE(at, std::string::npos);
  ASSERT_EQ(std::sscanf(svg.c_str() + at,
                        "<ellipse class='ellipse' cx='%lf' cy='%lf' rx='%lf' ry='%lf' transform='rotate(%lf",
                        &x, &y, &rx, &ry, &degrees),
            5);
  EXPECT_NEAR(rx / ry, 2.0, 0.01);
  // 95 % of both coordinates: sqrt(-2 ln 0.05) sigma, magnified as in the legend.
  const PlanFrame frame = plan_frame(plan);
  EXPECT_NEAR(rx,
              std::sqrt(-2 * std::log(0.05)) * 0.002 *
                  ellipse_exaggeration(plan.deployment, frame.extent_m()) * frame.px_per_m,
              0.01);
  EXPECT_NEAR(std::abs(std::remainder(degrees + 45, 180)), 0.0, 0.1);
}

TEST(SitePlan, SurvivesOddSites) {
  EXPECT_THAT(site_plan_svg({}), HasSubstr("</svg>"));
  PlanInput one;
  one.deployment.beacons = {test_beacon("far", 5.0e5, 4.0e6, 0.01, BeaconStatus::kCalibrated)};
  EXPECT_THAT(site_plan_svg(one), HasSubstr("far"));
  EXPECT_LT(site_plan_svg(one).size(), 20'000u);
  one.deployment.beacons.push_back(
      test_beacon("lost", std::numeric_limits<double>::quiet_NaN(), 0, 0.01, BeaconStatus::kUndetermined));
  const std::string svg = site_plan_svg(one);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("lost")));
  PlanInput drive;
  drive.tracks = {{true, std::vector<Eigen::Vector3d>(200'000, Eigen::Vector3d(1, 2, 0))}};
  EXPECT_LT(site_plan_svg(drive).size(), 100'000u);
}

TEST(SitePlan, DrawsMapsAsLayersWithClasses) {
  const PlanInput plan = full_report().plan;
  const std::string svg = site_plan_svg(plan);
  EXPECT_THAT(svg, HasSubstr("class='layer layer-0'"));
  EXPECT_THAT(svg, HasSubstr("class='layer layer-1'"));
  EXPECT_THAT(svg, HasSubstr("error [mm]:"));
  // Geometric between the least and the 95 % value: of 1, 2, 3 that is 2, as three values have no finer
  // quantile.
  const auto limits = map_classes(plan.maps[0]);
  ASSERT_EQ(limits.size(), kMapColours.size() - 1);
  EXPECT_NEAR(limits[0], std::pow(2.0, 1.0 / 7), 1e-12);
  EXPECT_TRUE(map_classes({"flat", "", {0, 0}, 1, 2, {3, 3}}).empty());
  EXPECT_THAT(
      site_plan_svg({{}, {}, {}, {{"flat", "", {0, 0}, 1, 2, {3, 3}}, {"empty", "", {0, 0}, 1, 0, {}}}}),
      HasSubstr("all the same"));
}

/// Relative luminance of a colour (WCAG 2.1).
double luminance(const std::string& hex) {
  double sum = 0.0;
  const double weight[3] = {0.2126, 0.7152, 0.0722};
  for (std::size_t i = 0; i < 3; ++i) {
    const double c = std::stoi(hex.substr(1 + 2 * i, 2), nullptr, 16) / 255.0;
    sum += weight[i] * (c <= 0.03928 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return sum;
}

TEST(SitePlan, MapColoursSurviveGreyPrint) {
  for (std::size_t i = 1; i < kMapColours.size(); ++i)
    EXPECT_GT(luminance(kMapColours[i]), 1.2 * luminance(kMapColours[i - 1]));
}

TEST(SitePlan, SideViewHasTheHeights) {
  const std::string svg = elevation_svg(full_report().plan);
  EXPECT_THAT(svg, HasSubstr("x, z in metres"));
  EXPECT_THAT(svg, HasSubstr(">B1</text>"));
  EXPECT_THAT(elevation_svg({}), HasSubstr("</svg>"));
}

}  // namespace site_plan_test
}  // namespace octant::survey
