// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "survey/report/report_sections.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_loss_test {

template <class Block>
const Block* find(const ReportSection& section) {
  for (const ReportBlock& block : section.blocks)
    if (const auto* found = std::get_if<Block>(&block)) return found;
  return nullptr;
}

ReportInput with_losses(std::size_t count) {
  ReportInput input = full_report();
  input.losses.clear();
  for (std::size_t i = 0; i < count; ++i) {
    // The worse the loss, the larger the values of its map.
    const double scale = static_cast<double>(count - i);
    input.losses.push_back({"B" + std::to_string(i), 1.0 - 0.001 * scale, scale, 2 * scale,
                            NamedMap{"HDOP", "", {0, 0}, 5.0, 2, {scale, 2 * scale, 3 * scale, 4 * scale}}});
  }
  return input;
}

TEST(ReportLoss, WorstFirstWithAllAtWorkToCompareWith) {
  const auto section = loss_section(with_losses(3));
  ASSERT_TRUE(section);
  const auto* table = find<ReportTable>(*section);
  ASSERT_NE(table, nullptr);
  ASSERT_EQ(table->rows.size(), 4U);
  EXPECT_EQ(table->rows[0][0].text, "none, all at work");
  EXPECT_EQ(table->rows[1][0].text, "B0");
  EXPECT_EQ(table->rows[1][1].text, "99.7") << "a share in percent";
  EXPECT_EQ(table->rows[1][2].text, "3.00");
  EXPECT_EQ(table->rows[1][3].text, "6.00");
  EXPECT_EQ(table->columns[2].name, "HDOP, median");
}

TEST(ReportLoss, MapsHaveOneScaleSoThatTheyCanBeCompared) {
  const auto section = loss_section(with_losses(3));
  const auto* drawing = find<ReportFigure>(*section);
  ASSERT_NE(drawing, nullptr);
  EXPECT_THAT(drawing->layers, testing::ElementsAre("none, all at work", "B0", "B1", "B2"));
  const auto figure = nlohmann::json::parse(drawing->interactive);
  std::vector<double> highest;
  for (const auto& trace : figure["data"])
    if (trace["type"] == "heatmap") highest.push_back(trace["zmax"].get<double>());
  ASSERT_EQ(highest.size(), 4U);
  for (const double high : highest) EXPECT_EQ(high, highest[0]);
}

TEST(ReportLoss, EachMapCrossesItsBeaconOut) {
  ReportInput input = with_losses(2);
  input.losses[0].beacon = "B1", input.losses[1].beacon = "B2";
  const auto section = loss_section(input);
  const auto figure = nlohmann::json::parse(find<ReportFigure>(*section)->interactive);
  std::vector<std::pair<int, double>> crosses;
  for (const auto& trace : figure["data"])
    if (trace.value("name", "") == "silent")
      crosses.emplace_back(trace["layer"].get<int>(), trace["y"][0].get<double>());
  // Layer 0 has all beacons in use; B1 is at (10, 0), B2 at (10, 8).
  EXPECT_THAT(crosses, testing::ElementsAre(std::pair(1, 0.0), std::pair(2, 8.0)));
}

TEST(ReportLoss, OfManyBeaconsTheWorstHaveMapsAndTheTableIsBounded) {
  const auto section = loss_section(with_losses(1000));
  EXPECT_EQ(find<ReportFigure>(*section)->layers.size(), 12U);
  EXPECT_EQ(find<ReportTable>(*section)->rows.size(), kMaxRows);
  EXPECT_EQ(find<ReportText>(*section)->text, "Maps of the beacons whose loss is worst.");
  EXPECT_EQ(find<ReportText>(*loss_section(with_losses(5))), nullptr);
}

TEST(ReportLoss, WithoutMapsThereIsATableAlone) {
  ReportInput input = with_losses(2);
  input.no_loss.reset();
  for (BeaconLoss& loss : input.losses) loss.map.reset(), loss.median.reset();
  const auto section = loss_section(input);
  EXPECT_EQ(find<ReportFigure>(*section), nullptr);
  EXPECT_EQ(find<ReportTable>(*section)->rows[0][2].text, "-") << "nothing is covered";
  input.losses.clear();
  EXPECT_FALSE(loss_section(input));
}

}  // namespace report_loss_test
}  // namespace octant::survey
