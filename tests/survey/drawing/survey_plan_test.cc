// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/survey_plan.h"
#include "survey/geometry/make_survey_model.h"

#include <cmath>
#include <cstdio>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace survey_plan_test {

using ::testing::HasSubstr;
using ::testing::Not;

Survey surveyed(const Scene& scene = test::small_scene()) {
  const Site site = test::small_site();
  return test::must(run_survey(test::must(make_survey_model(site, scene)), scene, nullptr));
}

/// Area in pixels of all rectangles of a colour, printed as "M x y h W v H h -W z".
std::map<std::string, double> areas_of(const std::string& svg) {
  const std::string begin = "<path class='cell' fill='";
  std::map<std::string, double> areas;
  for (auto at = svg.find(begin); at != std::string::npos; at = svg.find(begin, at + 1)) {
    const std::string colour = svg.substr(at + begin.size(), 7);
    const std::size_t end = svg.find("'/>", at);
    for (auto m = svg.find('M', at); m < end; m = svg.find('M', m + 1)) {
      double x = 0, y = 0, w = 0, h = 0;
      EXPECT_EQ(std::sscanf(svg.c_str() + m, "M%lf %lfh%lfv%lf", &x, &y, &w, &h), 4);
      areas[colour] += w * h;
    }
  }
  return areas;
}

TEST(SurveyPlan, BinsAreMillimetresNoFixOrNothing) {
  Survey survey = surveyed();
  FloorMap& map = survey.maps.front();
  map.values[0] = INFINITY;
  const PlanInput plan = survey_plan(survey, {&map}, 1000);
  const NamedMap& named = plan.maps.front();
  EXPECT_EQ(named.unit, "mm");
  EXPECT_EQ(named.columns, survey.grid.columns);
  EXPECT_DOUBLE_EQ(*named.tolerance, 3.0);
  EXPECT_TRUE(std::isinf(named.values[survey.grid.cells[0]]));
  EXPECT_DOUBLE_EQ(named.values[survey.grid.cells[1]], 1e3 * static_cast<double>(map.values[1]));
  EXPECT_TRUE(std::isnan(named.values[7 * 24 + 11])) << "in the column";
}

TEST(SurveyPlan, EachColourHasTheAreaOfItsBins) {
  Survey survey = surveyed();
  FloorMap& map = survey.maps.front();
  // A third is far inside the tolerance, a third far beyond it, a third has no fix.
  for (std::size_t i = 0; i < map.values.size(); ++i)
    map.values[i] = i % 3 == 0 ? 1e-4F : i % 3 == 1 ? 1.0F : INFINITY;
  const std::string svg = site_plan_svg(survey_plan(survey, {&map}, 1000));
  EXPECT_THAT(svg, HasSubstr(">no fix<"));
  const auto areas = areas_of(svg);
  ASSERT_EQ(areas.size(), 3U) << "what is off the floor is not painted";
  for (const auto& [colour, area] : areas) EXPECT_NEAR(area / areas.begin()->second, 1.0, 0.02) << colour;
}

TEST(SurveyPlan, WallsAreLinesAndObstaclesAreFilled) {
  Scene scene = test::small_scene();
  Survey survey = surveyed(scene);
  survey.model.beacons[0].name = "<B&0>";
  std::string svg = site_plan_svg(survey_plan(survey, {}, 10));
  EXPECT_THAT(svg, HasSubstr("<polygon class='obstacle'"));
  EXPECT_THAT(svg, HasSubstr("<polyline class='wall'"));
  EXPECT_THAT(svg, HasSubstr("<polyline class='route'"));
  EXPECT_THAT(svg, HasSubstr("&lt;B&amp;0&gt;</text>"));
  survey.scene.walls[0].blocks_sound = false;
  svg = site_plan_svg(survey_plan(survey, {}, 10));
  EXPECT_THAT(svg, Not(HasSubstr("<polygon class='obstacle'")));
}

/// National grids have seven digits before the point.
TEST(SurveyPlan, AxesOfANationalGridAreRead) {
  PlanInput plan;
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(500000, 5700000, 2), Eigen::Vector3d(500004, 5700002, 2)}) {
    plan.deployment.beacons.emplace_back();
    plan.deployment.beacons.back().position_m = p;
  }
  const std::string svg = site_plan_svg(plan);
  EXPECT_THAT(svg, HasSubstr(">500002<"));
  EXPECT_THAT(svg, HasSubstr(">5700001<"));
  EXPECT_THAT(svg, Not(HasSubstr("e+0")));
}

}  // namespace survey_plan_test
}  // namespace octant::survey
