// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/svg_chart.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/support/statistics.h"

namespace octant::survey {
namespace svg_chart_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(AxisTicks, AreRoundNumbersWithinTheAxisAtEvenSteps) {
  Random draws(20261125);
  for (int i = 0; i < 5000; ++i) {
    const double size = draws.log_uniform(1e-9, 1e9), low = draws.uniform(-3, 3) * size, high = low + size;
    const auto ticks = axis_ticks(low, high);
    // Six or so: a step of 1, 2, 5 or 10 is up to twice and a half of a sixth.
    ASSERT_GE(ticks.size(), 2U);
    ASSERT_LE(ticks.size(), 8U);
    const double step = ticks[1] - ticks[0], power = std::pow(10, std::round(std::log10(step) - 0.35));
    const double lead = step / power;
    EXPECT_LT(std::min({std::abs(lead - 1), std::abs(lead - 2), std::abs(lead - 5), std::abs(lead - 0.5)}),
              1e-6)
        << step;
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      EXPECT_GE(ticks[k], low - 1e-9 * step);
      EXPECT_LE(ticks[k], high + 1e-8 * step);
      EXPECT_NEAR(std::remainder(ticks[k], step) / step, 0.0, 1e-6) << "a multiple of the step";
      if (k > 0) EXPECT_NEAR((ticks[k] - ticks[k - 1]) / step, 1.0, 1e-6);
    }
    EXPECT_LT(ticks.front() - low, step * (1 + 1e-6)) << "none is left out at the beginning";
    EXPECT_LT(high - ticks.back(), step * (1 + 1e-6));
  }
}

TEST(AxisTicks, OfNoAxisAreNone) {
  EXPECT_TRUE(axis_ticks(1, 1).empty());
  EXPECT_TRUE(axis_ticks(2, 1).empty());
  EXPECT_TRUE(axis_ticks(0, std::numeric_limits<double>::infinity()).empty());
  EXPECT_TRUE(axis_ticks(std::nan(""), 1).empty());
}

TEST(AxisTicks, ZeroHasNoSign) {
  for (const double tick : axis_ticks(-1, 1))
    if (tick == 0.0) EXPECT_FALSE(std::signbit(tick));
}

TEST(NormalCounts, AreTheDistributionsWithItsTailsInTheOutermostBins) {
  const Histogram histogram{-2.0, 0.5, {1, 2, 3, 4, 5, 6, 7, 8}};
  const auto expected = normal_counts(histogram);
  ASSERT_EQ(expected.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    const double from = i == 0 ? -40.0 : -2.0 + 0.5 * static_cast<double>(i),
                 to = i == 7 ? 40.0 : -1.5 + 0.5 * static_cast<double>(i);
    EXPECT_NEAR(expected[i], 36 * (test::normal_cdf(to) - test::normal_cdf(from)), 1e-12);
  }
  EXPECT_NEAR(std::accumulate(expected.begin(), expected.end(), 0.0), 36.0, 1e-12);
  EXPECT_NEAR(normal_counts({0.0, 1.0, {9}})[0], 9.0, 1e-12) << "one bin holds all";
  EXPECT_TRUE(normal_counts({}).empty());
}

std::vector<std::pair<double, double>> points_of(const std::string& svg, const std::string& shape) {
  std::vector<std::pair<double, double>> points;
  std::size_t at = svg.find("<path class='" + shape + "' d='M", svg.find("</text>"));
  EXPECT_NE(at, std::string::npos);
  for (at = svg.find("d='", at) + 3; svg[at] == 'M' || svg[at] == 'L';) {
    double x = 0, y = 0;
    int read = 0;
    if (std::sscanf(svg.c_str() + at + 1, "%lf %lf%n", &x, &y, &read) != 2) break;
    points.emplace_back(x, y);
    at += 1 + static_cast<std::size_t>(read);
  }
  return points;
}

TEST(ErrorCurve, RisesFromTheLeastErrorToAllFixes) {
  const std::vector<double> quantiles_m = {0.001, 0.002, 0.003, 0.007, 0.021};
  const std::string svg = error_curve_svg(quantiles_m, 0.05);
  const auto points = points_of(svg, "line");
  ASSERT_EQ(points.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    // Both axes are linear: as far along as the quantile and the share are, to the tenth of a pixel printed.
    const double part = (points[i].first - points[0].first) / (points[4].first - points[0].first);
    EXPECT_NEAR(part, (quantiles_m[i] - 0.001) / 0.020, 1e-3);
    const double share = (points[i].second - points[0].second) / (points[4].second - points[0].second);
    EXPECT_NEAR(share, static_cast<double>(i) / 4, 1e-3);
  }
  EXPECT_LT(points[4].second, points[0].second) << "up";
  EXPECT_THAT(svg, HasSubstr("position error below [mm]"));
  EXPECT_THAT(svg, HasSubstr("tolerance"));
  EXPECT_THAT(error_curve_svg(quantiles_m, std::nullopt), Not(HasSubstr("tolerance")));
}

/// Seconds since 1970.
TEST(ResidualChart, LargeNumbersAreReadOnTheAxis) {
  ResidualChart chart{.by = "time", .unit = "s"};
  for (int i = 0; i < 5; ++i)
    chart.bins.push_back({.from = 1.7e9 + 100 * i, .to = 1.7e9 + 100 * (i + 1), .count = 3, .rms_s = 1e-5});
  const std::string svg = residual_chart_svg(chart);
  EXPECT_THAT(svg, HasSubstr(">1700000200<"));
  EXPECT_THAT(svg, Not(HasSubstr("e+09")));
}

TEST(ErrorCurve, OfNothingIsNothingAndOfOneIsAPoint) {
  EXPECT_EQ(error_curve_svg({}, 0.1), "");
  EXPECT_THAT(error_curve_svg({0.01}, std::nullopt), Not(HasSubstr("nan")));
  EXPECT_THAT(error_curve_svg({0.0, 0.0}, std::nullopt), Not(HasSubstr("nan"))) << "all fixes are right";
}

TEST(ResidualChartSvg, MarksStandAtTheMeansOfTheirBins) {
  const ResidualChart chart{"distance", "m", {{"", 2, 4, 9, 1e-6, 4e-6}, {"", 4, 8, 9, -2e-6, 3e-6}}};
  const std::string svg = residual_chart_svg(chart);
  EXPECT_THAT(svg, HasSubstr("residual [µs]"));
  EXPECT_THAT(svg, HasSubstr("distance [m]"));
  std::vector<std::pair<double, double>> means;
  for (auto at = svg.find("<circle class='mean'"); at != std::string::npos && means.size() < 2;
       at = svg.find("<circle class='mean'", at + 1)) {
    double x = 0, y = 0;
    ASSERT_EQ(std::sscanf(svg.c_str() + at, "<circle class='mean' cx='%lf' cy='%lf'", &x, &y), 2);
    means.emplace_back(x, y);
  }
  ASSERT_EQ(means.size(), 2U);
  // Zero is in the middle of the axis, 40 px from the top and 56 from the bottom of 330.
  const double zero = (40 + 330 - 56) / 2.0;
  EXPECT_NEAR((means[1].second - zero) / (zero - means[0].second), 2.0, 0.02);
  // Bins from 2 to 8 over the width between 74 and 880: middles at 3 and 6.
  EXPECT_NEAR(means[0].first, 74 + (880 - 74) * 1 / 6.0, 0.06);
  EXPECT_NEAR(means[1].first, 74 + (880 - 74) * 4 / 6.0, 0.06);
}

TEST(ResidualChartSvg, OfManyNamesSomeAreShownAndAllAreText) {
  ResidualChart chart{"beacon", "", {}};
  for (int i = 0; i < 200; ++i) chart.bins.push_back({"<B" + std::to_string(i) + ">", 0, 0, 5, 1e-6, 2e-6});
  const std::string svg = residual_chart_svg(chart);
  EXPECT_THAT(svg, Not(HasSubstr("<B")));
  std::size_t names = 0;
  for (auto at = svg.find("&lt;B"); at != std::string::npos; at = svg.find("&lt;B", at + 1)) ++names;
  EXPECT_GE(names, 12U);
  EXPECT_LE(names, 25U);
}

TEST(ResidualChartSvg, OfNothingIsAnEmptyChart) {
  for (const ResidualChart& chart : {ResidualChart{"beacon", "", {}}, ResidualChart{"time", "s", {}},
                                     ResidualChart{"time", "s", {{"", 3, 3, 1, 0, 0}}}}) {
    EXPECT_THAT(residual_chart_svg(chart), HasSubstr("</svg>"));
    EXPECT_THAT(residual_chart_svg(chart), Not(HasSubstr("nan")));
    EXPECT_THAT(residual_chart_svg(chart), Not(HasSubstr("inf")));
  }
}

TEST(HistogramSvg, HasABarForEachBinThatHoldsSomething) {
  const std::string svg = histogram_svg({-2.0, 1.0, {3, 0, 6, 1}});
  const std::size_t at = svg.find("<path class='count' d='");
  ASSERT_NE(at, std::string::npos);
  const std::string bars = svg.substr(at, svg.find("/>", at) - at);
  EXPECT_EQ(std::count(bars.begin(), bars.end(), 'z'), 3);
  double base = 0, first_top = 0, third_top = 0, x = 0, width = 0;
  ASSERT_EQ(
      std::sscanf(bars.c_str(), "<path class='count' d='M%lf %lfV%lfh%lf", &x, &base, &first_top, &width), 4);
  const std::size_t third = bars.find('M', bars.find('z'));
  ASSERT_EQ(std::sscanf(bars.c_str() + third, "M%lf %lfV%lf", &x, &base, &third_top), 3);
  EXPECT_NEAR((base - third_top) / (base - first_top), 2.0, 0.01) << "as high as counted";
  EXPECT_THAT(histogram_svg({}), Not(HasSubstr("nan")));
}

}  // namespace svg_chart_test
}  // namespace octant::survey
