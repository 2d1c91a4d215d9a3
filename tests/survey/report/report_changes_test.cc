// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/report/report_sections.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_changes_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

BeaconChange change(const std::string& name, double shift_m, std::optional<double> p) {
  BeaconChange c;
  c.name = name;
  c.shift_m = {shift_m, 0, 0};
  c.sigma_m = {0.001, 0.002, 0.003};
  c.p = p;
  return c;
}

ReportInput with_changes(std::vector<BeaconChange> beacons) {
  ReportInput input = full_report();
  input.changes = Changes{};
  input.changes->since = "2025-01-01T00:00:00Z";
  input.changes->limit_p = 1e-3;
  input.changes->beacons = std::move(beacons);
  return input;
}

std::vector<std::string> texts_of(const ReportInput& input) {
  std::vector<std::string> texts;
  const auto section = changes_section(input);
  for (const ReportBlock& block : section->blocks)
    if (const auto* text = std::get_if<ReportText>(&block)) texts.push_back(text->text);
  return texts;
}

ReportTable table_of(const ReportInput& input) {
  const auto section = changes_section(input);
  for (const ReportBlock& block : section->blocks)
    if (const auto* table = std::get_if<ReportTable>(&block)) return *table;
  ADD_FAILURE() << "no table";
  return {};
}

TEST(ReportChanges, TheLeastLikelyStandFirst) {
  std::vector<BeaconChange> beacons = {change("chance", 0.001, 0.4), change("held", 0, {}),
                                       change("moved", 0.02, 1e-9), change("new device", 0.001, 0.3)};
  beacons[2].significant = true;
  beacons[3].delay_p = 1e-6, beacons[3].delay_significant = true, beacons[3].delay_change_s = 4e-5;
  const ReportTable table = table_of(with_changes(beacons));
  std::vector<std::string> names;
  for (const auto& row : table.rows) names.push_back(row[0].text);
  EXPECT_THAT(names, testing::ElementsAre("moved", "new device", "chance", "held"));
  EXPECT_EQ(table.rows[0].back().text, "moved");
  EXPECT_EQ(table.rows[0].back().tone, Tone::kBad);
  EXPECT_EQ(table.rows[1].back().text, "delay changed");
  EXPECT_EQ(table.rows[2].back().text, "as before");
  EXPECT_EQ(table.rows[2].back().tone, Tone::kPlain);
  EXPECT_EQ(table.rows[3][7].text, "-") << "no p where both are held";
  EXPECT_THAT(table.caption, HasSubstr("as rare by chance as once in 1000"));
}

TEST(ReportChanges, NumbersAreInTheUnitsOfTheirColumns) {
  auto beacons = std::vector{change("B1", 0.0234, 1e-9), change("B2", -0.001, 0.5)};
  beacons[0].delay_change_s = -2.5e-6, beacons[0].delay_sigma_s = 1e-6;
  const ReportTable table = table_of(with_changes(beacons));
  EXPECT_EQ(table.columns[1].name, "x [mm]");
  EXPECT_EQ(table.rows[0][1].text, "23.40");
  EXPECT_EQ(table.rows[0][2].text, "1.00");
  EXPECT_EQ(table.rows[0][6].text, "3.00") << "sigma z";
  EXPECT_EQ(table.columns[8].name, "delay [µs]");
  EXPECT_EQ(table.rows[0][8].text, "-2.50");
  EXPECT_EQ(table.rows[1][1].text, "-1.00");
  for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
}

TEST(ReportChanges, AShiftOfTheFrameIsSaidToBeOne) {
  auto beacons = std::vector{change("B1", 0.02, 1e-9), change("B2", 0.02, 1e-9)};
  for (auto& b : beacons) b.significant = b.by_datum = true;
  beacons[1].delay_significant = true;
  ReportInput input = with_changes(beacons);
  input.changes->doubted_control_points = {"B0"};
  const ReportTable table = table_of(input);
  EXPECT_EQ(table.rows[0].back().text, "shift: see the datum");
  EXPECT_EQ(table.rows[0].back().tone, Tone::kAttention);
  EXPECT_EQ(table.rows[1].back().text, "delay changed; shift: see the datum");
  EXPECT_THAT(texts_of(input),
              Contains(HasSubstr("Control point B0 is held where the site file has it, and its "
                                 "delay changed by more than chance. If it was knocked")));
  input.changes->doubted_control_points = {"B0", "B3"};
  EXPECT_THAT(texts_of(input),
              Contains(HasSubstr("Control points B0, B3 are held where the site file has them, and "
                                 "their delays")));
  EXPECT_EQ(changes_sentence(*input.changes),
            "Since 2025-01-01T00:00:00Z: 0 of 2 beacons moved by more than chance explains, the delay of 1 "
            "changed.");
}

TEST(ReportChanges, WhatCameAndWentIsListed) {
  ReportInput input = with_changes({});
  EXPECT_EQ(texts_of(input).size(), 1U);
  EXPECT_EQ(texts_of(input)[0],
            "Since 2025-01-01T00:00:00Z: 0 of 0 beacons moved by more than chance explains.");
  input.changes->gone = {"B7", "B9"};
  input.changes->added = {"B10"};
  input.changes->same_datum = false;
  input.changes->speed_change_mps = -0.25, input.changes->speed_sigma_mps = 0.1;
  const auto texts = texts_of(input);
  EXPECT_THAT(texts, Contains("No longer there: B7, B9."));
  EXPECT_THAT(texts, Contains("New: B10."));
  EXPECT_THAT(texts, Contains(HasSubstr("The datum is another one")));
  EXPECT_THAT(texts, Contains("Speed at the same temperature: -0.250 m/s, sigma 0.100 m/s."));
  input.changes.reset();
  EXPECT_FALSE(changes_section(input));
}

TEST(ReportChanges, TellWhatToLookAtOnSite) {
  auto beacons = std::vector{change("B1", 0.02, 1e-9), change("B2", 0.02, 1e-9), change("B3", 0.02, 1e-9)};
  beacons[0].significant = true;
  beacons[1].delay_significant = true;
  beacons[2].significant = beacons[2].by_datum = true;
  const auto steps = next_steps(with_changes(beacons));
  EXPECT_THAT(steps, Contains("Look at B1 on site: moved since the earlier deployment."));
  EXPECT_THAT(steps, Contains(HasSubstr("Look at B2 on site: another delay")));
  EXPECT_THAT(steps, Not(Contains(HasSubstr("B3")))) << "nothing is said of it";
}

TEST(ReportChanges, TellWhatIsSilentAndWhatAllDelaysShare) {
  auto beacons = std::vector{change("B1", 0.0, 1e-9), change("B2", 0.0, 1e-9)};
  for (BeaconChange& c : beacons) c.delay_significant = true;
  ReportInput input = with_changes(beacons);
  input.changes->silent = {{"B4", 120.0, 0.0}, {"robot/r2", 300.4, 12.0, true, 61.0}};
  input.changes->not_observed = {"B7"};
  input.changes->found.emplace_back();
  input.changes->found[0].kind = ChangeKind::kDelay;
  input.changes->found[0].subject = kAllBeaconsSubject;
  const auto steps = next_steps(input);
  EXPECT_THAT(steps, Contains("Look at B4 on site: 120 arrivals were expected, and 0 received."));
  EXPECT_THAT(
      steps, Contains("Look at robot/r2 on site: 300 arrivals were expected from 61 s on, and 12 received."));
  EXPECT_THAT(steps, Contains(HasSubstr("the vehicle's electronics")));
  EXPECT_THAT(steps, Not(Contains(HasSubstr("B1")))) << "each beacon is as it was";
}

}  // namespace report_changes_test
}  // namespace octant::survey
