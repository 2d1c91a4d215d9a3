// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/text.h"

#include "tests/io/io_support.h"

namespace octant::io {
namespace text_test {

using test::expect_error;

TEST(Text, ShowsOnlyTheBeginningOfLongValues) {
  EXPECT_EQ(in_quotes("B1"), "'B1'");
  EXPECT_EQ(in_quotes("a\nb"), "'a b'");
  EXPECT_LT(in_quotes(std::string(16'000'000, 'B')).size(), 100u);
  // Forty bytes end within a character of two: it is left out whole.
  std::string umlauts = "x";
  for (int i = 0; i < 30; ++i) umlauts += "\xC3\xBC";
  EXPECT_TRUE(check_utf8(in_quotes(umlauts), ""));
}

TEST(Text, SuggestsWhatWasMeant) {
  EXPECT_EQ(suggestion("sigma_mp", {"model", "sigma_mps"}), "did you mean 'sigma_mps'?");
  EXPECT_EQ(suggestion("b1", {"B1", "B7"}), "did you mean 'B1'?");
  EXPECT_EQ(suggestion("tof", {"time_s", "tof_s"}), "did you mean 'tof_s'?");
  EXPECT_EQ(suggestion("B99", {"B0", "B1"}), "known: B0, B1");
  EXPECT_EQ(suggestion("anything", {}), "");
}

TEST(Text, ParsesDecimalNumbersAndNothingElse) {
  double value = 0;
  for (const auto& [text, expected] : std::vector<std::pair<const char*, double>>{{"1", 1},
                                                                                  {"+1.5", 1.5},
                                                                                  {"-2e-9", -2e-9},
                                                                                  {".5", 0.5},
                                                                                  {"1.0E3", 1000},
                                                                                  {"1e400", INFINITY},
                                                                                  {"inf", INFINITY}}) {
    EXPECT_EQ(parse_number(text, value), NumberText::kNumber) << text;
    EXPECT_EQ(value, expected) << text;
  }
  EXPECT_EQ(parse_number("nan", value), NumberText::kNumber);
  EXPECT_TRUE(std::isnan(value));
  EXPECT_EQ(parse_number("", value), NumberText::kEmpty);
  for (const char* text : {"1,5", "0x10", "1_000", "abc", "1 2", "--1", "+-1", "1e", "+", "true"}) {
    EXPECT_EQ(parse_number(text, value), NumberText::kNotNumber) << text;
  }
}

TEST(Text, ExactNumbersReadBackTheSame) {
  EXPECT_TRUE(rc::check("parse_number(exact(x)) == x", [] {
    const double value = test::some_number();
    double back = 0;
    RC_ASSERT(parse_number(exact(value), back) == NumberText::kNumber);
    RC_ASSERT(back == value);
  }));
}

TEST(Text, NamesThePlaceOfWhatIsNotUtf8) {
  EXPECT_TRUE(check_utf8("plain, Süd, 北, 🜨\n", "f"));
  expect_error(check_utf8("one\ntwo \xFF three", "f"), 2, "byte 0xFF");
  EXPECT_NE(check_utf8("Empf\xE4nger", "f").error().advice.find("CSV UTF-8"), std::string::npos);
  expect_error(check_utf8(std::string("one\ntwo\n\0", 9), "f"), 3, "byte 0x00");
  expect_error(check_utf8("\xFF\xFEt\0", "f"), 1, "UTF-16");
  for (const char* bad :
       {"\xC0\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xE2\x82", "\x80", "\xF0\x80\x80\x80"}) {
    EXPECT_FALSE(check_utf8("aaaaaaaaaaaaaaaa" + std::string(bad), "f")) << bad;
  }
}

TEST(Text, FindsAByteThatIsNoTextAnywhere) {
  EXPECT_TRUE(rc::check("one wrong byte is found where it is", [] {
    std::string text(static_cast<std::size_t>(*rc::gen::inRange(1, 40)), 'x');
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    text[at] = *rc::gen::element('\0', '\xFE', '\x80');
    const auto result = check_utf8(text, "f");
    RC_ASSERT(!result.has_value());
    RC_ASSERT(result.error().column == static_cast<int>(at) + 1);
  }));
}

}  // namespace text_test
}  // namespace octant::io
