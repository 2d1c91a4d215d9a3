// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/report/report_sections.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_residuals_test {

using ::testing::HasSubstr;
using ::testing::Not;

template <class Block>
const Block* find(const ReportSection& section) {
  for (const ReportBlock& block : section.blocks)
    if (const auto* found = std::get_if<Block>(&block)) return found;
  return nullptr;
}

TEST(ReportResiduals, OfVeryManyNamesThoseThatStickOutAreShown) {
  ReportInput input = full_report();
  input.residuals = {{"beacon", "", {}}};
  for (int i = 0; i < 1000; ++i)
    input.residuals[0].bins.push_back({"B" + std::to_string(i), 0, 0, 9, 0.0, 1e-8 * ((i * 37) % 1000)});
  const auto section = residuals_section(input);
  const auto* table = find<ReportTable>(*section);
  ASSERT_EQ(table->rows.size(), kMaxRows);
  for (const auto& row : table->rows)
    EXPECT_GE((std::stoi(row[0].text.substr(1)) * 37) % 1000, 1000 - static_cast<int>(kMaxRows));
  EXPECT_THAT(find<ReportFigure>(*section)->caption, HasSubstr("the 400 of 1000 bins whose RMS is largest"));
}

TEST(ReportResiduals, OnePointIsNoChart) {
  ReportInput input = full_report();
  for (ResidualChart& chart : input.residuals) chart.bins.resize(1);
  input.standardised.reset();
  const auto section = residuals_section(input);
  ASSERT_TRUE(section);
  EXPECT_EQ(find<ReportFigure>(*section), nullptr);
  input.residuals.clear();
  EXPECT_FALSE(residuals_section(input));
}

TEST(ReportResiduals, SayOfHowManyTheyAre) {
  ReportInput input = full_report();
  EXPECT_THAT(find<ReportText>(*residuals_section(input))->text, Not(HasSubstr("Of 2000"))) << "of all";
  input.looked_at = 500;
  EXPECT_THAT(find<ReportText>(*residuals_section(input))->text,
              HasSubstr("Of 500 of the 2000 arrivals, at even distances"));
}

}  // namespace report_residuals_test
}  // namespace octant::survey
