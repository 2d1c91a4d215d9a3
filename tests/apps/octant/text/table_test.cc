// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/table.h"

#include <sstream>

#include <gtest/gtest.h>

namespace octant::app {
namespace {

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

}  // namespace
}  // namespace octant::app
