// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/site_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/survey/report_input.h"

namespace octant::survey {
namespace site_sheet_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(SiteSheet, TagIsJsonWhateverTheName) {
  Deployment d = full_report().plan.deployment;
  for (const std::string name : {"B1", "\"];//", "<script>",
                                 "Gr\xc3\xbc\xc3\x9f"
                                 "e",
                                 "\xff"}) {
    d.beacons[1].name = name;
    d.beacons[1].position_m.x() = 10.00004;
    const auto tag = nlohmann::json::parse(beacon_tag(d, d.beacons[1], "abc"));
    if (name != "\xff") EXPECT_EQ(tag["beacon"], name);
    EXPECT_EQ(tag["site"], "hall");
    EXPECT_EQ(tag["position_m"], nlohmann::json({10.0, 0.0, 2.5}));
    EXPECT_EQ(tag["deployment"], "abc");
  }
}

TEST(SiteSheet, CodeHasTheStandardsFrame) {
  // Version 1 of the standard has 21 modules a side, 4 of white around; the finder pattern's upper edge is 7
  // dark modules.
  const std::string svg = qr_svg("OCTANT");
  EXPECT_THAT(svg, HasSubstr("viewBox='0 0 29 29'"));
  EXPECT_THAT(svg, HasSubstr("M4 4h7v1h-7z"));
  EXPECT_THAT(svg, HasSubstr("M18 4h7v1h-7z"));
  EXPECT_THAT(qr_svg(std::string(2331, 'x')), Not(::testing::IsEmpty()));  // the most that level M holds
  EXPECT_THAT(qr_svg(std::string(2332, 'x')), ::testing::IsEmpty());
}

TEST(SiteSheet, NamesAreText) {
  Deployment d = full_report().plan.deployment;
  d.site = d.beacons[0].name = "<img src=x>";
  d.beacons[2].status = BeaconStatus::kUndetermined;
  const std::string html = site_sheet_html(d, "<b>");
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("not determined"));
  EXPECT_THAT(html, HasSubstr("x</dt><dd>10.0000\u00a0m, U\u00a0=\u00a0"
                              "4\u00a0mm"));
}

}  // namespace site_sheet_test
}  // namespace octant::survey
