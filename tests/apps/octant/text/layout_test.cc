// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <sstream>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "apps/octant/text/layout.h"

namespace octant::app {
namespace layout_test {

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Paragraph, KeepsAllWordsAndBreaksBetweenThem) {
  EXPECT_TRUE(rc::check("no line is wider than it may be", [] {
    const auto text = *rc::gen::container<std::string>(rc::gen::element('a', 'b', 'c', ' ', ' ', '\n'));
    const auto columns = *rc::gen::inRange<std::size_t>(5, 30), indent = *rc::gen::inRange<std::size_t>(0, 4);
    const std::string broken = paragraph(text, columns, indent);
    RC_ASSERT(words_of(broken) == words_of(text));
    RC_ASSERT(broken.back() == '\n');
    const auto lines = lines_of(broken);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const auto words = words_of(lines[i]);
      RC_ASSERT(lines[i].size() <= columns || words.size() <= 1U);
      if (i > 0) RC_ASSERT(lines[i].substr(0, indent) == std::string(indent, ' '));
    }
  }));
}

TEST(Paragraph, FillsItsLines) {
  EXPECT_EQ(paragraph("one two three four", 9), "one two\nthree\nfour\n");
  EXPECT_EQ(paragraph("one two three four", 13), "one two three\nfour\n") << "to the last column";
  EXPECT_EQ(paragraph("one two three four", 12), "one two\nthree four\n");
}

TEST(Paragraph, NewlinesOfTheTextStay) {
  EXPECT_EQ(paragraph("one\ntwo three", 80, 2), "one\n  two three\n");
  EXPECT_EQ(paragraph("one\n", 80), "one\n");
  EXPECT_EQ(paragraph("", 80), "\n");
}

TEST(Paragraph, WhatStandsInTheFirstLineAlreadyCounts) {
  EXPECT_EQ(paragraph("one two three", 12, 4, 4), "one two\n    three\n");
  EXPECT_EQ(paragraph("one two three", 12, 4, 0), "one two\n    three\n");
  EXPECT_EQ(paragraph("one two", 12, 4, 8), "one\n    two\n");
}

TEST(Paragraph, WidthsAreThoseOfCharacters) {
  EXPECT_EQ(columns_of("Süd 北"), 5U);
  EXPECT_EQ(columns_of(""), 0U);
  EXPECT_EQ(paragraph("üüü üüü", 7), "üüü üüü\n");
}

TEST(NamedLine, BeginsBehindItsName) {
  const std::string text = named_line("beacons", std::string(40, 'a') + " " + std::string(30, 'b'));
  EXPECT_EQ(text, "beacons          " + std::string(40, 'a') + "\n" + std::string(17, ' ') +
                      std::string(30, 'b') + "\n");
}

}  // namespace layout_test

namespace layout_test {

TEST(Table, ColumnsAreAsWideAsTheirWidestCell) {
  const Table table{"lr", {{"beacon", "x [m]"}, {"B1", "10.25"}, {"Süd-Ost", "-3"}}};
  EXPECT_EQ(table.text(),
            "beacon   x [m]\n"
            "B1       10.25\n"
            "Süd-Ost     -3\n")
      << "two blanks between them; characters count, not bytes";
}

TEST(Table, NoLineEndsWithBlanks) {
  const Table table{"lll", {{"a", "b", "c"}, {"long word", "", ""}, {"", "x", ""}}};
  std::istringstream lines(table.text());
  for (std::string line; std::getline(lines, line);) EXPECT_FALSE(line.ends_with(' ')) << line;
}

TEST(Table, RowsMayBeShortOrTooLong) {
  EXPECT_EQ((Table{"ll", {{"a"}, {}, {"b", "c", "d"}}}).text(), "a\n\nb  c\n");
  EXPECT_EQ(Table{}.text(), "");
}

}  // namespace layout_test

}  // namespace octant::app
