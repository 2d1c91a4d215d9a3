// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report/report.h"

#include <cmath>
#include <map>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/drawing/escape.h"
#include "survey/drawing/plotly_js.h"
#include "survey/page/report_html.h"
#include "survey/page/report_style.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_test {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

/// A page without plotly.js itself, so that tests search what we wrote.
std::string page(const ReportInput& input) { return to_html(report_document(input), "PACKED"); }

TEST(Report, SaysThingsInTheOrderOfTheirUse) {
  std::vector<std::string> ids;
  for (const auto& section : report_document(full_report()).sections) ids.push_back(section.id);
  // Advice and positions come first, the method last.
  EXPECT_THAT(
      ids, ::testing::ElementsAre("next", "plan", "verdict", "warnings", "changes", "beacons", "verification",
                                  "determined", "loss", "left-out", "residuals", "words", "provenance"));
}

TEST(Report, ThePlanHasAnArrowToWhatMoved) {
  ReportInput input = full_report();
  ASSERT_TRUE(input.changes && input.changes->beacons[0].moved());
  const std::string moved = to_html(report_document(input), "");
  EXPECT_EQ(count(moved, "class='move'"), 1u);
  EXPECT_THAT(moved, HasSubstr("Arrows: moves since the earlier calibration"));
  input.changes->beacons[0].significant = false;
  const std::string still = to_html(report_document(input), "");
  EXPECT_EQ(count(still, "class='move'"), 0u);
  EXPECT_THAT(still, Not(HasSubstr("Arrows:")));
}

TEST(Report, TheMapOfWhatWasLeftOutHasALineToEachBeacon) {
  ReportInput input = full_report();
  const auto section_of = [](const ReportInput& of) {
    const std::string html = to_html(report_document(of), "");
    const std::size_t at = html.find("<h2 id='left-out'>");
    return at == std::string::npos ? std::string() : html.substr(at, html.find("<h2 ", at + 4) - at);
  };
  const std::string section = section_of(input);
  EXPECT_THAT(section, HasSubstr("20 of 2020 arrivals were left out: 20 late (echo)"));
  EXPECT_EQ(count(section, "<path class='miss' d="), 2u);        // late, from both stops to B1
  EXPECT_EQ(count(section, "<path class='miss early' d="), 1u);  // early, from the first to B2
  EXPECT_EQ(count(section, "<circle class='missed'"), 3u);       // two places and the legend's
  EXPECT_THAT(section, HasSubstr("18 left out at x 2.00 m, y 2.00 m"));
  EXPECT_THAT(section,
              HasSubstr("<th scope='row'>7</th><td>2.00</td><td>2.00</td><td>40</td><td>15</td><td>3</td>"));
  EXPECT_LT(section.find("<th scope='row'>7<"), section.find("<th scope='row'>8<")) << "most first";
  input.misses.clear();
  EXPECT_EQ(section_of(input), "");
}

TEST(Report, StopsThatStickOutAreNamed) {
  ReportInput input = full_report();
  const auto text = [&] { return report_markdown(input); };
  EXPECT_THAT(text(), HasSubstr("stick out at stop 7 (3.3 times the RMS of all): did the vehicle move"));
  EXPECT_THAT(text(), Not(HasSubstr("stop 8 (")));
  input.stops[0].looked_at = 4;  // so few may be so by chance
  EXPECT_THAT(text(), Not(HasSubstr("stick out")));
}

TEST(Report, TablesLeadToTheWordsThatTheyUse) {
  ReportInput input = full_report();
  const std::string html = to_html(report_document(input), "");
  EXPECT_THAT(html, HasSubstr("How large the squared residuals are."));
  EXPECT_GT(count(html, "href='#words'>Words</a></caption>"), 4u);
  input.words.clear();
  EXPECT_EQ(count(to_html(report_document(input), ""), "#words"), 0u);
}

TEST(Report, WhatOneMeasurementSettlesIsOneStep) {
  ReportInput input = full_report();
  input.weak = {{"beacon B1 (not heard)", "drive where it is heard", 0.0, false, true},
                {"beacon B2 (not heard)", "drive where it is heard", 0.0, false, true}};
  input.plan.deployment.beacons[1].status = BeaconStatus::kUndetermined;
  const std::vector<std::string> steps = next_steps(input);
  ASSERT_FALSE(steps.empty());
  EXPECT_EQ(steps[0], "To determine beacon B1 (not heard), beacon B2 (not heard): drive where it is heard.");
  for (const std::string& step : steps) EXPECT_THAT(step, Not(HasSubstr("Hear B1"))) << "it was told";
}

TEST(Report, StillPageIsClosedAndWithoutScript) {
  const std::string html = report_html(full_report(), {.interactive = false});
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("script-src")));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  EXPECT_FALSE(std::regex_search(html, std::regex("href='[^#]")));  // anchors of the page alone
  EXPECT_THAT(html, Not(HasSubstr("url(")));
  EXPECT_FALSE(std::regex_search(html, std::regex("[^a-z]-?(nan|inf)[^a-z]")));
  EXPECT_EQ(count(html, "<svg"), 8u);  // plan, side, errors, left out, two residual charts, histogram, loss
  EXPECT_LT(html.size(), 100'000u);
}

TEST(Report, LivePageCarriesFiguresAsData) {
  const std::string html = page(full_report());
  EXPECT_THAT(html, HasSubstr("script-src 'unsafe-inline'"));
  EXPECT_EQ(count(html, "<script type='application/json'"), 7u);
  EXPECT_THAT(html, HasSubstr("PACKED"));
  if (plotly_js().empty()) GTEST_SKIP() << "plotly.js was not at hand when this was built";
  EXPECT_LT(report_html(full_report()).size(), 1'800'000u);
}

TEST(Report, WhatIsThinnedIsSaid) {
  ReportInput input = full_report();
  EXPECT_THAT(page(input), Not(HasSubstr("vehicle states")));
  input.plan.tracks[1].points_m.assign(10'000, {1, 2, 0});
  EXPECT_THAT(page(input), HasSubstr("vehicle states"));
  input.plan.tracks[1].thinned_from = 1'000'000;
  EXPECT_THAT(page(input), HasSubstr("Of 1000002 vehicle states"));
  EXPECT_LT(page(input).size(), 600'000u);
}

// The scale that is the same to all kinds of colour vision; plotly.js knows it by name.
TEST(Report, LiveMapsAreCividis) {
  const std::string html = page(full_report());
  EXPECT_GT(count(html, "heatmap"), 0u);
  EXPECT_EQ(count(html, "\"colorscale\":\"Cividis\""), count(html, "\"heatmap\""));
}

TEST(Report, TextFromDataIsText) {
  for (const std::string evil : {"<script>alert(1)</script>", "\"];//", "</script><b>", "]]>", "&lt;",
                                 "<img src=x onerror=alert(1)>&\"'", "--><!--", "a\x01\n|b"}) {
    const ReportInput input = report_full_of(evil);
    const std::string html = page(input), neutral = page(report_full_of("x"));
    // The markup does not depend on the texts.
    for (const char* mark : {"<script", "</script", "<b>", "<img", "<!--", "-->", "<td", "<li", "<text"})
      EXPECT_EQ(count(html, mark), count(neutral, mark)) << evil << mark;
    EXPECT_THAT(html, HasSubstr(escape_xml(evil)));
    // Embedded JSON contains no markup.
    const std::regex data("<script type='application/json'[^>]*>([^<]*)</script>");
    const auto first = std::sregex_iterator(html.begin(), html.end(), data);
    EXPECT_EQ(std::distance(first, std::sregex_iterator()), 7);
    for (auto it = first; it != std::sregex_iterator(); ++it)
      EXPECT_EQ((*it)[1].str().find_first_of("<>&"), std::string::npos);

    const std::string markdown = report_markdown(input);
    EXPECT_EQ(count(markdown, "\n|"), count(report_markdown(report_full_of("x")), "\n|"))
        << evil;  // tables keep their rows
    for (const char* mark : {"<script", "<img", "<b>"}) EXPECT_THAT(markdown, Not(HasSubstr(mark)));
  }
  EXPECT_EQ(escape_xml("a<b>&\"'\x01"), "a&lt;b&gt;&amp;&quot;&#39; ");
  EXPECT_EQ(escape_markdown("a|b*<i>\n&"), "a\\|b\\*&lt;i&gt; &amp;");
  EXPECT_EQ(escape_script_json("\"</script>&\""), "\"\\u003c/script\\u003e\\u0026\"");
  EXPECT_THAT(page(report_full_of("\xe2\x80\xa8 line separator")), HasSubstr("\\u2028 line separator"));
}

TEST(Report, WhatTheDataContradictStandsBeforeAllElse) {
  ReportInput input = full_report();
  input.evaluation.reset();
  input.plan.deployment.tolerance.beacon_m = 1.0;
  input.plan.deployment.contradictions = {
      {ContradictionKind::kControlPoint, "B3", "at (1, 2, 3) m", "at (1, 2, 4) m", 12.0, "survey B3 again"}};
  const Verdict v = verdict(input);
  EXPECT_EQ(v.grade, Grade::kContradicted);
  EXPECT_THAT(v.sentence,
              HasSubstr("Control point B3: stated at (1, 2, 3) m, found at (1, 2, 4) m (12 sigma)."));
  EXPECT_EQ(next_steps(input).front(), "Survey B3 again.");
  EXPECT_THAT(report_markdown(input), HasSubstr("Contradicted"));
  input.outcome = Outcome::kRefused;
  EXPECT_EQ(verdict(input).grade, Grade::kRefused);
}

TEST(Report, VerdictFollowsTheGates) {
  ReportInput input = full_report();
  input.evaluation.reset();
  EXPECT_EQ(verdict(input).grade, Grade::kUnjudged);
  EXPECT_THAT(verdict(input).sentence, HasSubstr("no tolerance"));
  input.plan.deployment.tolerance.beacon_m = 0.0048;  // 2.45 x 2 mm = 4.9 mm
  EXPECT_EQ(verdict(input).grade, Grade::kPoor);
  EXPECT_THAT(verdict(input).sentence, HasSubstr("outside the tolerance of 4.8 mm"));
  input.plan.deployment.tolerance.beacon_m = 0.005;
  EXPECT_EQ(verdict(input).grade, Grade::kGood);
  input.evaluation = Evaluation{};
  input.evaluation->matched = 3;
  input.evaluation->gates = {{"fix_m", 0.01, 0.02, false}};
  EXPECT_EQ(verdict(input).grade, Grade::kPoor);
  input.evaluation.reset();
  input.plan.deployment.beacons[2].status = BeaconStatus::kUndetermined;
  EXPECT_EQ(verdict(input).grade, Grade::kPoor);
  EXPECT_THAT(verdict(input).sentence, HasSubstr("1 could not be determined"));
  input.outcome = Outcome::kRefused;
  input.message = "the scale is free";
  EXPECT_EQ(verdict(input).grade, Grade::kRefused);
  EXPECT_EQ(verdict(input).sentence, "Nothing was exported: the scale is free.");
  input.message = "the scale is free; nothing is exported. To resolve this: tape.";
  EXPECT_EQ(verdict(input).sentence, "The scale is free; nothing is exported. To resolve this: tape.");
}

TEST(Report, NextStepsBeginWithWhatBlocks) {
  ReportInput input = full_report();
  input.changes.reset();
  input.weak = {{"the offset", "warm up", 0.001, false}, {"the scale", "tape a distance", 0.5, true}};
  EXPECT_EQ(next_steps(input).front(), "To determine the scale: tape a distance.");
  input.weak.clear();
  input.plan.deployment.tolerance.beacon_m = 0.01;
  EXPECT_THAT(next_steps(input), ::testing::ElementsAre(HasSubstr("Nothing needs to be measured")));
  input.beacons[1].redundancy = 0.1;
  EXPECT_THAT(next_steps(input), ::testing::ElementsAre(HasSubstr("stations that hear B1")));
  input.plan.deployment.statistics.variance_factor = 9.0;
  EXPECT_THAT(next_steps(input), ::testing::Contains(HasSubstr("9 times the variance")));
  input.plan.deployment.beacons[1].status = BeaconStatus::kUndetermined;
  EXPECT_THAT(next_steps(input).front(), HasSubstr("Hear B1 from more places"));
}

TEST(Report, NextStepsSayWhatMostArrivalsWereLeftOutFor) {
  ReportInput input = full_report();
  input.changes.reset();
  input.weak.clear();
  const auto step_with = [&](std::vector<LeftOutNote> notes) {
    input.left_out = std::move(notes);
    std::size_t all = 0;
    for (const LeftOutNote& note : input.left_out) all += note.count;
    input.plan.deployment.statistics.arrivals = 1000;
    input.plan.deployment.statistics.rejected = all;
    return next_steps(input).front();
  };
  const LeftOutNote late{"late (echo)", 600, LeftOutCause::kLate},
      early{"early (spurious)", 500, LeftOutCause::kEarly},
      no_pose{"no vehicle pose at its time", 649, LeftOutCause::kNoPose}, rows{"not a number", 900};
  EXPECT_THAT(step_with({late}), HasSubstr("Look for reflectors and obstacles: 600 of 1600"));
  EXPECT_THAT(step_with({late, early}),
              HasSubstr("swapped channels: 1100 of 2100 arrivals were left out, 600 late"));
  EXPECT_THAT(step_with({{"late (echo)", 30, LeftOutCause::kLate}, no_pose}),
              HasSubstr("Tell where the vehicle was: 649 of 1679"));
  EXPECT_THAT(step_with({rows}), HasSubstr("900 for \"not a number\""));
  EXPECT_THAT(step_with({{"late (echo)", 100, LeftOutCause::kLate}}), Not(HasSubstr("left out")));
}

TEST(Report, NumbersAreInTheTable) {
  const std::string html = page(full_report());
  // Labels of the columns on a phone, each once.
  EXPECT_THAT(html, HasSubstr("#beacon-table td:nth-child(10)::before{content:'r'}"));
  // x 10, U = 2 sigma = 4 mm, delay 100 us with U 4 us, r, MDB, arrivals, rejected.
  EXPECT_THAT(html, HasSubstr("<th "
                              "scope='row'>B1</th><td>10.0000</td><td>0.0000</td><td>2.5000</td><td>4.00</"
                              "td><td>4.00</td><td>4.00</td>"
                              "<td>100.000</td><td>4.000</td><td>0.75</td><td>50.0</td><td>650</td><td>10</"
                              "td><td class='words'>calibrated</td>"));
  EXPECT_THAT(report_markdown(full_report()),
              HasSubstr("| B1 | 10.0000 | 0.0000 | 2.5000 | 4.00 | 4.00 | 4.00 | 100.000 | 4.000 | 0.75 | "
                        "50.0 | 650 | 10 | calibrated |"));
}

TEST(Report, NumbersKeepTheirUnits) {
  ReportInput input = full_report();
  input.warnings = {"off by 12 mm, 3.5 µs (95 %); 2 models of 20 beacons at 21 degC."};
  EXPECT_THAT(
      page(input),
      HasSubstr("off by 12&#160;mm, 3.5&#160;µs (95&#160;%); 2 models of 20 beacons at 21&#160;degC."));
}

TEST(Report, MarkdownHasAllSections) {
  const std::string markdown = report_markdown(full_report());
  for (const auto& section : report_document(full_report()).sections)
    EXPECT_THAT(markdown, HasSubstr("\n## " + escape_markdown(section.title) + "\n"));
  EXPECT_THAT(markdown, ::testing::StartsWith("# hall\n"));
}

TEST(Report, ManyBeaconsStaySmall) {
  ReportInput input = full_report();
  for (int i = 0; i < 5000; ++i) {
    input.plan.deployment.beacons.push_back(
        test_beacon("N" + std::to_string(i), i % 70, i / 70, 0.001 + 1e-7 * i, BeaconStatus::kCalibrated));
    input.beacons.push_back({"N" + std::to_string(i), 10, 0, 0.5, 1e-5, 1.0, 1e-5, 1e-3, 1e-4, 1e-3});
    input.residuals[0].bins.push_back({"N" + std::to_string(i), 0, 0, 10, 0, 1e-5});
  }
  const std::string still = report_html(input, {.interactive = false});
  EXPECT_LT(still.size(), 500'000u);
  EXPECT_LT(page(input).size(), 900'000u);  // and 1.6 MB of plotly.js
  EXPECT_THAT(still, HasSubstr("The 400 of 5003 beacons that are known least well"));
  EXPECT_THAT(still, HasSubstr("N4999"));
}

/// Contrast of two colours (WCAG 2.1).
double contrast(const std::string& a, const std::string& b) {
  const auto luminance = [](const std::string& hex) {
    double sum = 0.0;
    const double weight[3] = {0.2126, 0.7152, 0.0722};
    for (std::size_t i = 0; i < 3; ++i) {
      const double c = std::stoi(hex.substr(1 + 2 * i, 2), nullptr, 16) / 255.0;
      sum += weight[i] * (c <= 0.03928 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return sum;
  };
  const double la = luminance(a), lb = luminance(b);
  return (std::max(la, lb) + 0.05) / (std::min(la, lb) + 0.05);
}

TEST(Report, PaletteHasTheContrastOfAA) {
  EXPECT_NEAR(contrast("#ffffff", "#000000"), 21.0, 1e-9);
  EXPECT_NEAR(contrast("#777777", "#ffffff"), 4.48, 0.01);  // the well-known grey that just fails
  const std::string style(page_style());
  const std::regex block(R"(:root\{(color-scheme:light dark;)?(--ink[^}]*)\})"),
      pair(R"(--([a-z]+):(#[0-9a-f]{6}))");
  int schemes = 0;
  for (auto it = std::sregex_iterator(style.begin(), style.end(), block); it != std::sregex_iterator();
       ++it, ++schemes) {
    const std::string text = (*it)[2];
    std::map<std::string, std::string> colour;
    for (auto p = std::sregex_iterator(text.begin(), text.end(), pair); p != std::sregex_iterator(); ++p)
      colour[(*p)[1]] = (*p)[2];
    ASSERT_EQ(colour.size(), 13u);
    for (const char* words : {"ink", "soft", "good", "attention", "bad", "link"})
      for (const char* ground : {"paper", "card"})
        EXPECT_GE(contrast(colour[words], colour[ground]), 4.5) << words << " on " << ground;  // 1.4.3
    for (const char* mark : {"beacon", "control", "track", "fix"})
      EXPECT_GE(contrast(colour[mark], colour["paper"]), 3.0) << mark;  // 1.4.11
  }
  EXPECT_EQ(schemes, 2);
}

TEST(Report, PageIsMarkedUpForAllReaders) {
  const std::string html = page(full_report());
  EXPECT_THAT(html, HasSubstr("<html lang='en'>"));
  EXPECT_THAT(html, HasSubstr("class='skip' href='#main'"));
  EXPECT_EQ(count(html, "<h1"), 1u);
  EXPECT_EQ(count(html, "<h2"), 13u);
  EXPECT_EQ(count(html, "<h3"), 0u);
  EXPECT_EQ(count(html, "<table"), count(html, "<caption"));
  EXPECT_EQ(count(html, "<figure"), count(html, "<figcaption"));
  EXPECT_EQ(count(html, "role='img' aria-label="), count(html, "<svg"));
  EXPECT_EQ(count(html, "<input"), count(html, "<label"));
}

}  // namespace report_test
}  // namespace octant::survey
