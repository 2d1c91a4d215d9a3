// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/report_markdown.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_markdown_test {

using ::testing::HasSubstr;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Cells of a row: text between pipes without a backslash.
std::size_t cells_of(const std::string& line) {
  std::size_t pipes = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\\')
      ++i;
    else if (line[i] == '|')
      ++pipes;
  }
  return pipes - 1;
}

TEST(ReportMarkdown, WritesEveryBlockByItsWords) {
  ReportDocument document{.title = "hall",
                          .subtitle = "of 2026",
                          .tone = Tone::kGood,
                          .grade = "Good",
                          .sentence = "All is well.",
                          .sections = {}};
  ReportTable table{"t", "What must hold", {{"gate", true}, {"limit"}}, {{{"a"}, {"1 mm"}}, {{"b"}, {"-"}}}};
  ReportFigure figure{"f", "A drawing.", "<svg/>", "", "Map", {"HDOP", "error"}};
  document.sections = {
      {"one", "First", {ReportText{"Words."}, ReportList{{"x", "y"}, true}, ReportList{{"z"}}}},
      {"two", "Second", {table, figure}}};
  EXPECT_EQ(to_markdown(document),
            "# hall\n\nof 2026\n\n**Good.** All is well.\n\n"
            "## First\n\nWords.\n\n1. x\n2. y\n\n- z\n\n"
            "## Second\n\nWhat must hold:\n\n| gate | limit |\n|:---|---:|\n| a | 1 mm |\n| b | - |\n\n"
            "Drawing in the HTML report: A drawing. Map: HDOP, error.\n");
}

TEST(ReportMarkdown, TablesHaveAsManyCellsInEachRowWhateverTheNamesAre) {
  for (const char* name : {"B1", "a|b", "\\|", "`", "a\nb", "- x", "|||", "<td>"}) {
    std::size_t columns = 0, rows = 0;
    for (const std::string& line : lines_of(report_markdown(report_full_of(name)))) {
      if (!line.starts_with('|')) {
        columns = 0;
        continue;
      }
      if (columns == 0) columns = cells_of(line);
      EXPECT_EQ(cells_of(line), columns) << line;
      ++rows;
    }
    EXPECT_GT(rows, 20U);
  }
}

TEST(ReportMarkdown, HeadingsAreTheSectionsAndNothingElseIsOne) {
  const ReportInput input = report_full_of("# not a heading");
  std::size_t headings = 0;
  for (const std::string& line : lines_of(report_markdown(input))) headings += line.starts_with('#');
  EXPECT_EQ(headings, 1 + report_document(input).sections.size());
}

TEST(ReportMarkdown, EndsWithOneNewline) {
  const std::string text = report_markdown(full_report());
  EXPECT_TRUE(text.ends_with("\n"));
  EXPECT_FALSE(text.ends_with("\n\n"));
  const std::string empty = to_markdown({});
  EXPECT_THAT(empty, HasSubstr("# "));
  EXPECT_FALSE(empty.ends_with("\n\n"));
}

}  // namespace report_markdown_test
}  // namespace octant::survey
