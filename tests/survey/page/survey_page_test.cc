// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/survey_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "survey/drawing/binned_map.h"
#include "survey/drawing/palette.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/map/survey_csv.h"
#include "survey/page/survey_verdict.h"
#include "tests/support/worlds.h"
#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace survey_page_test {

using test::must;
using test::small_scene;
using test::small_site;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(SurveyPage, NamesFromDataAreEscapedAndNothingRuns) {
  Scene scene = small_scene();
  Site site = small_site();
  site.name = "<script>alert(1)</script>";
  site.beacons[0].name = "a\"b<i>";
  scene.routes[0].name = "'&<b>";
  const auto survey = must(run_survey(must(make_survey_model(site, scene)), scene, nullptr));
  const std::string html = survey_html(
      survey, {.input = "<x>", .created = "now", .program = "octant", .command = "", .warnings = {"<w>"}},
      false);
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  for (const char* raw : {"<script", "<i>", "<b>", "<x>", "<w>", "http://localhost", " src="})
    EXPECT_THAT(html, Not(HasSubstr(raw)));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;"));
  EXPECT_THAT(survey_csv(survey), HasSubstr("\"a\"\"b<i>"));
}

TEST(SurveyPage, TheBannersColourSaysWhatItsWordsSay) {
  const Scene scene = small_scene();
  auto survey = must(run_survey(must(make_survey_model(small_site(), scene)), scene, nullptr));
  const auto tone_with = [&](std::optional<double> tolerance_m, double covered) {
    survey.model.tolerance.fix_m = tolerance_m;
    survey.covered_fraction = covered;
    const ReportDocument page = survey_document(survey, {});
    EXPECT_EQ(page.grade, to_string(survey_verdict(survey).grade));
    EXPECT_EQ(page.sections.front().id, "next") << "what to do comes first";
    return page.tone;
  };
  survey.fix_fraction = 1.0;
  survey.mirror_fraction = 0.0;
  EXPECT_EQ(tone_with(0.05, 1.0), Tone::kAttention) << "nothing says how far a beacon is heard";
  EXPECT_EQ(survey_verdict(survey).grade, Grade::kUnjudged);
  EXPECT_EQ(survey_verdict(survey).sentence,
            "if every beacon is heard everywhere, 100.0 % of the floor is within the tolerance of 50 mm.");
  EXPECT_THAT(survey_verdict(survey).next, testing::Contains(HasSubstr("State how far a beacon is heard")));
  EXPECT_EQ(tone_with(0.05, 0.9), Tone::kBad) << "even so";
  survey.model.hearing.range_m = 20.0;
  EXPECT_EQ(tone_with(0.05, 1.0), Tone::kGood);
  EXPECT_EQ(survey_verdict(survey).sentence, "100.0 % of the floor is within the tolerance of 50 mm.");
  EXPECT_EQ(tone_with(0.05, 0.9), Tone::kBad);
  EXPECT_EQ(survey_verdict(survey).grade, Grade::kPoor);
  survey.mirror_fraction = 0.1;
  EXPECT_EQ(
      survey_verdict(survey).sentence,
      "90.0 % of the floor is within the tolerance of 50 mm, in 10.0 % a mirror image explains the ranges "
      "as well.");
  survey.mirror_fraction = 0.0;
  survey.fix_fraction = 0.95;
  EXPECT_EQ(survey_verdict(survey).sentence,
            "90.0 % of the floor is within the tolerance of 50 mm, 5.0 % beyond it, 5.0 % without a fix.");
  EXPECT_THAT(survey_verdict(survey).next.front(), HasSubstr("octant plan SITE.yaml --tolerance 0.05"));
  EXPECT_EQ(tone_with({}, 1.0), Tone::kAttention) << "nothing to judge by";
  EXPECT_EQ(survey_verdict(survey).grade, Grade::kUnjudged);
}

// Four beacons were Good where nine were asked for.
TEST(SurveyPage, FewerBeaconsThanAskedForAreNotGood) {
  Scene scene = small_scene();
  scene.coverage = 9;
  scene.acoustics.range_m = 20.0;
  auto survey = must(run_survey(must(make_survey_model(small_site(), scene)), scene, nullptr));
  survey.covered_fraction = 1.0;
  EXPECT_EQ(survey_verdict(survey).grade, Grade::kPoor);
  EXPECT_THAT(survey_verdict(survey).sentence,
              testing::EndsWith("0.0 % of the floor hears the 9 beacons that the scene asks for."));
  EXPECT_THAT(survey_verdict(survey).next,
              testing::Contains(HasSubstr("octant plan SITE.yaml --tolerance 0.003 --coverage 9")));
  survey.k_covered_fraction = 1.0;
  EXPECT_EQ(survey_verdict(survey).grade, Grade::kGood);
  survey.scene.coverage = 0;  // what nobody asked for is told alone
  survey.k_covered_fraction = 0.0;
  EXPECT_EQ(survey_verdict(survey).grade, Grade::kGood);
}

// Green inside, amber near, red beyond, at the site's tolerance; in a drawing with a script and in one
// without.
TEST(SurveyPage, ColoursAreAnchoredAtTheTolerance) {
  Scene scene = small_scene();
  Site site = small_site();
  site.tolerance.fix_m = 0.02;
  const auto survey = must(run_survey(must(make_survey_model(site, scene)), scene, nullptr));
  const BinnedMap sigma = cell_map(survey, *survey.find("sigma_m")),
                  hdop = cell_map(survey, *survey.find("hdop"));
  BinnedMap one = sigma;
  one.columns = one.rows = 1;
  one.bins = {BinnedMap::Bin::kValue};
  const auto colour = [&](double part) {
    one.values = {part * 0.02};
    return colour_of(one, 0);
  };
  const auto is_green = [](const auto& c) { return c[1] > c[0] && c[1] > c[2]; };
  for (const double part : {0.01, 0.3, 0.6, 0.74}) EXPECT_TRUE(is_green(colour(part))) << part;
  for (const double part : {0.8, 0.99}) EXPECT_EQ(colour(part), rgb_of("#f6b53c")) << part;
  for (const double part : {1.01, 1.6, 3.0, 100.0}) {
    const auto c = colour(part);
    EXPECT_TRUE(c[0] > 1.5 * c[1] && c[0] > 1.5 * c[2]) << part;
  }
  // Values without a limit are never red, however large.
  BinnedMap plain = hdop;
  EXPECT_FALSE(plain.against_tolerance);
  plain.bins[0] = BinnedMap::Bin::kValue;
  plain.values[0] = 10 * plain.high;
  EXPECT_EQ(colour_of(plain, 0), rgb_of(kMapColours.back()));
  const auto document = survey_document(survey, {});
  const auto& figure = std::get<ReportFigure>(document.sections[1].blocks.front());
  EXPECT_THAT(figure.svg, HasSubstr("against the tolerance of 20 mm"));
  const auto data = nlohmann::json::parse(figure.interactive)["data"];
  EXPECT_EQ(data[0]["zmax"], 45.0) << "mm: two and a quarter of the tolerance";
  EXPECT_EQ(data[0]["colorscale"].back()[1], kToleranceColours.back());
}

TEST(SurveyPage, LivePlanHasWallsAndRoutesByName) {
  Scene scene = small_scene();
  scene.walls[0].name = "</script><b>";
  scene.walls.push_back({.name = "glass", .points_m = {{1, 6}, {2, 6}}, .blocks_sound = false});
  scene.routes[0].name = "a & b";
  const auto survey = must(run_survey(must(make_survey_model(small_site(), scene)), scene, nullptr));
  const auto document = survey_document(survey, {});
  const ReportFigure* figure = nullptr;
  for (const auto& section : document.sections)
    for (const auto& block : section.blocks)
      if (const auto* f = std::get_if<ReportFigure>(&block)) figure = f;
  ASSERT_NE(figure, nullptr);
  EXPECT_EQ(figure->interactive.find_first_of("<>&"), std::string::npos);
  const auto data = nlohmann::json::parse(figure->interactive)["data"];
  const auto trace = [&](const char* name) {
    return *std::find_if(data.begin(), data.end(), [&](const auto& t) { return t["name"] == name; });
  };
  const auto walls = trace("wall"), route = trace("route");
  // The column closed, the curtain open; objects that transmit sound are no walls here.
  EXPECT_EQ(walls["x"], nlohmann::json::parse("[5, 7, 7, 5, 5, null, 9, 9, null]"));
  EXPECT_EQ(walls["y"], nlohmann::json::parse("[3, 3, 5, 5, 3, null, 0, 4, null]"));
  EXPECT_EQ(walls["text"][0], "&lt;/script&gt;&lt;b&gt;");  // plotly.js reads labels as HTML
  EXPECT_EQ(walls["hovertext"][6], "wall curtain");
  EXPECT_EQ(route["x"].size(), 4u);
  EXPECT_EQ(route["text"][0], "a &amp; b");
}

}  // namespace survey_page_test
}  // namespace octant::survey
