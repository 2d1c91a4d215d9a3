// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/map_svg.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/drawing/palette.h"
#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Survey empty_survey() {
  Survey survey;
  survey.model.floor_m = {{0, 0}, {4, 0}, {4, 2}, {0, 2}};
  return survey;
}

BinnedMap two_by_four() {
  BinnedMap map{.name = "sigma_m", .title = "sigma <1>", .unit = "m", .columns = 4, .rows = 2};
  map.bin_m = 1.0;
  map.bins.assign(8, BinnedMap::Bin::kValue);
  map.values = {0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0};
  return map;
}

/// Area in pixels of all rectangles of a colour: what is printed as "M x y h W v H h -W z".
std::map<std::string, double> areas_of(const std::string& svg) {
  std::map<std::string, double> areas;
  for (auto at = svg.find("<path fill='"); at != std::string::npos; at = svg.find("<path fill='", at + 1)) {
    const std::string colour = svg.substr(at + 12, 7);
    const std::size_t end = svg.find("'/>", at);
    for (auto m = svg.find('M', at); m < end; m = svg.find('M', m + 1)) {
      double x = 0, y = 0, w = 0, h = 0;
      EXPECT_EQ(std::sscanf(svg.c_str() + m, "M%lf %lfh%lfv%lf", &x, &y, &w, &h), 4);
      areas[colour] += w * h;
    }
  }
  return areas;
}

TEST(MapSvg, EachColourHasTheAreaOfItsBins) {
  BinnedMap map = two_by_four();
  map.bins[7] = BinnedMap::Bin::kOffFloor;
  const auto areas = areas_of(map_svg(empty_survey(), map));
  ASSERT_EQ(areas.size(), 2U) << "what is off the floor is not painted";
  double low = 0, high = 0;
  for (const auto& [colour, area] : areas) (colour == kMapColours.front() ? low : high) += area;
  // Three bins against four; each rectangle is 0.3 pixels wider and higher, of some 150.
  EXPECT_NEAR(low / high, 3.0 / 4.0, 0.01);
}

TEST(MapSvg, ATitleAndAScaleSayWhatItIs) {
  BinnedMap map = two_by_four();
  map.low = 0.0, map.high = 0.045;
  std::string svg = map_svg(empty_survey(), map);
  EXPECT_THAT(svg, HasSubstr("<title>sigma &lt;1&gt;</title>"));
  EXPECT_THAT(svg, HasSubstr(">45 mm and more; grey: no fix<"));
  map.against_tolerance = true;
  svg = map_svg(empty_survey(), map);
  for (const char* words : {">22.5 mm<", ">tolerance 45 mm<", ">90 mm<"}) EXPECT_THAT(svg, HasSubstr(words));
  for (const char* colour : kToleranceColours) EXPECT_THAT(svg, HasSubstr(colour));
}

TEST(MapSvg, WallsAreLinesAndObstaclesAreFilled) {
  Survey survey = empty_survey();
  survey.scene = test::small_scene();
  survey.model.beacons = {{"<B&0>", {1, 1, 2}}};
  const std::string svg = map_svg(survey, two_by_four());
  EXPECT_THAT(svg, HasSubstr("<polygon class='obstacle'"));
  EXPECT_THAT(svg, HasSubstr("<polyline class='wall'"));
  EXPECT_THAT(svg, HasSubstr("<polyline class='route'"));
  EXPECT_THAT(svg, HasSubstr("&lt;B&amp;0&gt;</text>"));
  EXPECT_THAT(map_svg(survey, two_by_four(), {.beacon_names = false}), Not(HasSubstr("&lt;B")));
  survey.scene.walls[0].blocks_sound = false;
  EXPECT_THAT(map_svg(survey, two_by_four()), Not(HasSubstr("<polygon class='obstacle'")));
}

TEST(MapSvg, ACorridorOnEndIsNoTower) {
  Survey survey;
  survey.model.floor_m = {{0, 0}, {1, 0}, {1, 100}, {0, 100}};
  BinnedMap map{.columns = 1, .rows = 100};
  map.bin_m = 1.0;
  map.bins.assign(100, BinnedMap::Bin::kValue);
  map.values.assign(100, 0.5);
  double width = 0, height = 0;
  const std::string svg = map_svg(survey, map, {.width_px = 500});
  ASSERT_EQ(std::sscanf(svg.c_str() + svg.find("viewBox"), "viewBox='0 0 %lf %lf'", &width, &height), 2);
  EXPECT_EQ(width, 500);
  EXPECT_LT(height, 1.5 * width);
}

/// National grids have seven digits before the point.
TEST(MapSvg, AxesOfANationalGridAreRead) {
  Survey survey;
  const Eigen::Vector2d corner(500000, 5700000);
  for (const Eigen::Vector2d& p : empty_survey().model.floor_m) survey.model.floor_m.push_back(corner + p);
  BinnedMap map = two_by_four();
  map.origin_m = corner;
  const std::string svg = map_svg(survey, map);
  EXPECT_THAT(svg, HasSubstr(">500001<"));
  EXPECT_THAT(svg, HasSubstr(">5700001<"));
  EXPECT_THAT(svg, Not(HasSubstr("e+0")));
}

TEST(FigureText, IsAsPeopleReadIt) {
  EXPECT_EQ(figure_text(0.0421, "m"), "42.1 mm");
  EXPECT_EQ(figure_text(0.0994, "m"), "99.4 mm");
  EXPECT_EQ(figure_text(0.0996, "m"), "0.0996 m");
  EXPECT_EQ(figure_text(3.2, "m"), "3.2 m");
  EXPECT_EQ(figure_text(1.414, ""), "1.41");
  EXPECT_EQ(figure_text(0.25, "rad"), "0.25 rad");
  EXPECT_EQ(figure_text(std::numeric_limits<double>::infinity(), "m"), "no fix");
  EXPECT_EQ(figure_text(1234.5, "m"), "1234 m") << "nobody reads 1.23e+03";
  EXPECT_EQ(figure_text(2500, ""), "2500");
}

TEST(Palette, HexadecimalDigitsAreColours) {
  EXPECT_EQ(rgb_of("#00204d"), (std::array<std::uint8_t, 3>{0x00, 0x20, 0x4d}));
  EXPECT_EQ(rgb_of("#ffe945"), (std::array<std::uint8_t, 3>{255, 233, 69}));
  EXPECT_EQ(kToleranceParts.size() + 1, kToleranceColours.size()) << "a limit between any two";
  EXPECT_TRUE(std::is_sorted(kToleranceParts.begin(), kToleranceParts.end()));
}

}  // namespace
}  // namespace octant::survey
