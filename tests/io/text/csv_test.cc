// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/csv.h"

#include "io/tof/run_parts.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace csv_test {

using Rows = std::vector<std::vector<std::string>>;

Result<Rows> all_rows(const std::string& text) {
  CsvReader csv(text, "t.csv");
  Rows rows;
  while (csv.next_row()) {
    rows.emplace_back();
    for (std::size_t i = 0; i < csv.header().size(); ++i)
      rows.back().emplace_back(csv.field(static_cast<int>(i)));
  }
  if (csv.error()) return fail(*csv.error());
  return rows;
}

TEST(Csv, ReadsPlainAndQuotedFields) {
  EXPECT_EQ(all_rows("a,b\n1,2\n").value(), (Rows{{"1", "2"}}));
  EXPECT_EQ(all_rows("a,b\n1,2").value(), (Rows{{"1", "2"}}));
  EXPECT_EQ(all_rows("a, b\n 1 ,\t2 \n").value(), (Rows{{"1", "2"}}));
  EXPECT_EQ(all_rows("a,b\n\"x,y\",\"he said \"\"no\"\"\"\n").value(), (Rows{{"x,y", "he said \"no\""}}));
  EXPECT_EQ(all_rows("a,b\n\"two\nlines\",2\n3,4\n").value(), (Rows{{"two\nlines", "2"}, {"3", "4"}}));
  EXPECT_EQ(all_rows("a,b\n,\n").value(), (Rows{{"", ""}}));
  EXPECT_EQ(all_rows("a,b\n").value(), Rows{});
  EXPECT_EQ(all_rows("a,b\n1,2,\n").value(), (Rows{{"1", "2"}})) << "a comma at the end of each row";
}

TEST(Csv, AcceptsMarksCommentsBlankLinesAndCrLf) {
  EXPECT_EQ(all_rows("\xEF\xBB\xBF# made by x\r\n\r\n# and y; z\r\na,b\r\n1,2\r\n\r\n3,4\r\n").value(),
            (Rows{{"1", "2"}, {"3", "4"}}));
}

TEST(Csv, CountsLinesThroughCommentsBlankLinesAndQuotes) {
  CsvReader csv("# c\n\na,b\n\"x\ny\",2\n\n3,4\n", "t.csv");
  EXPECT_EQ(csv.line(), 3);
  ASSERT_TRUE(csv.next_row());
  EXPECT_EQ(csv.line(), 4);
  ASSERT_TRUE(csv.next_row());
  EXPECT_EQ(csv.line(), 7);
}

TEST(Csv, SaysWhatIsWrongAndWhere) {
  using test::expect_error;
  expect_error(all_rows(""), 0, "empty", "t.csv");
  expect_error(all_rows("# only a comment\n"), 0, "empty", "t.csv");
  expect_error(all_rows("# c\na;b\n1,5;2\n"), 2, "semicolons");
  expect_error(all_rows("a\tb\n1\t2\n"), 1, "tabs");
  expect_error(all_rows("a,b,a\n"), 1, "column 'a' is there twice");
  expect_error(all_rows("a,b\n1,2\n3\n"), 3, "cut off");
  expect_error(all_rows("a,b\n1\n3,4\n"), 2, "1 field; expected 2");
  expect_error(all_rows("a,b\n1,5,2,5\n"), 2, "decimal commas");
  expect_error(all_rows("a,b\n1,\"2\n3,4\n"), 2, "not closed");
  expect_error(all_rows("a,b\n1,\"2\"x\n"), 2, "behind a closing quote");
  expect_error(all_rows("a,b\n1," + std::string(1, '\0') + "\n"), 2, "0x00");
  expect_error(all_rows("a,b\n" + std::string(1'000'000, ',') + "\n"), 2, "fields");
  expect_error(all_rows(std::string(1'000'000, ',') + "\n"), 1, "more than 65536 fields");
}

TEST(Csv, NamesTheColumnOfAField) {
  CsvReader csv("a,b,c\n1,\"x\", oops\n", "t.csv");
  const int b = csv.require("b"), c = csv.require("c");
  ASSERT_TRUE(csv.next_row());
  double value = 0;
  EXPECT_FALSE(csv.number(c, value));
  EXPECT_EQ(csv.error()->message(), "t.csv:2:8: c is 'oops'; expected a finite number");
  EXPECT_EQ(csv.field(b), "x");
  EXPECT_FALSE(csv.next_row()) << "the first error sticks";
}

TEST(Csv, MissingColumnsSayWhatIsThere) {
  CsvReader csv("time_s,tof\n", "t.csv");
  EXPECT_EQ(csv.require("tof_s"), -1);
  EXPECT_THAT(csv.error()->message(), testing::HasSubstr("column 'tof_s' is missing (columns: time_s, tof)"));
  CsvReader headless("1.0,2.0\n", "t.csv");
  (void)headless.require("tof_s");
  EXPECT_THAT(headless.error()->message(), testing::HasSubstr("header row itself seems to be missing"));
}

TEST(Csv, AllMissingColumnsAreNamedAtOnceWithGuesses) {
  CsvReader csv("Timestamp,anchor,range_m,receiver\n", "t.csv");
  for (const char* name : {"time_s", "beacon", "tof_s"}) EXPECT_EQ(csv.require(name), -1);
  EXPECT_THAT(
      csv.error()->message(),
      testing::HasSubstr(
          "columns 'time_s', 'beacon', 'tof_s' are missing (columns: Timestamp, anchor, range_m, receiver)"));
  EXPECT_THAT(
      csv.error()->message(),
      testing::HasSubstr("is it 'Timestamp' for 'time_s', 'anchor' for 'beacon', 'range_m' for 'tof_s'?"));
}

TEST(Csv, WholeNumbers) {
  CsvReader csv("a,b,c,d\n7,-7,7.0,9223372036854775807\n", "t.csv");
  ASSERT_TRUE(csv.next_row());
  std::int64_t value = 0;
  EXPECT_TRUE(csv.integer(0, value) && value == 7);
  EXPECT_TRUE(csv.integer(1, value) && value == -7);
  EXPECT_TRUE(csv.integer(2, value) && value == 7);
  EXPECT_FALSE(csv.integer(3, value));
}

TEST(CsvField, IsInQuotesWhereItNeedsThem) {
  EXPECT_EQ(csv_field("plain text"), "plain text");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(csv_field("a\nb"), "\"a\nb\"");
  EXPECT_EQ(csv_field(" a#"), "\" a#\"");
  EXPECT_EQ(csv_field(""), "");
}

TEST(Csv, ReadsBackEveryField) {
  EXPECT_TRUE(rc::check("rows of csv_field() read back", [] {
    const auto columns = *rc::gen::inRange<std::size_t>(2, 5);
    std::string text;
    for (std::size_t c = 0; c < columns; ++c) text.append(c > 0 ? ",c" : "c").append(std::to_string(c));
    Rows rows(static_cast<std::size_t>(*rc::gen::inRange(0, 6)));
    for (auto& row : rows) {
      text += *rc::gen::element<std::string>("\n", "\r\n", "\n\n");
      for (std::size_t c = 0; c < columns; ++c) {
        row.push_back("x" +
                      *rc::gen::container<std::string>(rc::gen::element('a', ',', '"', '\n', ' ', ';', '#')) +
                      "x");
        text.append(c > 0 ? "," : "").append(csv_field(row.back()));
      }
    }
    const auto back = all_rows(text);
    RC_ASSERT(back.has_value());
    RC_ASSERT(*back == rows);
  }));
}

}  // namespace csv_test
}  // namespace octant::io
