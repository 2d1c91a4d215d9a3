// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/plain_number.h"

#include <bit>
#include <optional>
#include <vector>

#include "io/text/text.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace plain_number_test {

/// With what must be readable before it, and something else behind.
template <class Read>
auto read_within(const std::string& text, const Read& read) {
  const std::string padded = std::string(kBeforeNumber, '9') + text + ",99999999";
  const char* begin = padded.data() + kBeforeNumber;
  return read(begin, begin + text.size());
}

std::optional<double> number(const std::string& text) {
  return read_within(text, [&](const char* begin, const char* end) -> std::optional<double> {
    double value = 0.0;
    if (read_plain_number(begin, begin + std::min(text.find('.'), text.size()), end, value)) return value;
    return std::nullopt;
  });
}

std::optional<std::int64_t> integer(const std::string& text) {
  return read_within(text, [](const char* begin, const char* end) -> std::optional<std::int64_t> {
    std::int64_t value = 0;
    if (read_plain_integer(begin, end, value)) return value;
    return std::nullopt;
  });
}

TEST(PlainNumber, ReadsWhatIsPlain) {
  EXPECT_EQ(number("0"), 0.0);
  EXPECT_EQ(number("12"), 12.0);
  EXPECT_EQ(number("-0.0327"), -0.0327);
  EXPECT_EQ(number("12345678.87654321"), 12345678.87654321);
  EXPECT_TRUE(std::signbit(*number("-0")));
  EXPECT_EQ(integer("-17"), -17);
  EXPECT_EQ(integer("99999999"), 99999999);
}

TEST(PlainNumber, LeavesTheRest) {
  for (const char* text :
       {"",      "-",  ".",  ".5",    "5.",   "-.5",       "+5",          "1e5",
        "nan",   "1 ", " 1", "1.2.3", "1,2",  "123456789", "1.123456789", "99999999.99999999",
        "/",     ":",  "1/", "1:",    "\xB0", "1\xFF",     "--1",         "0x1",
        "1.\xBA"}) {
    EXPECT_EQ(number(text), std::nullopt) << text;
  }
  for (const char* text : {"", "-", "1.0", "123456789", "1 ", "/", ":", "a"})
    EXPECT_EQ(integer(text), std::nullopt) << text;
}

TEST(PlainNumber, AgreesWithTheGeneralReaderToTheLastBit) {
  EXPECT_TRUE(rc::check("decimal texts", [] {
    const auto digits = [] {
      return *rc::gen::container<std::string>(*rc::gen::inRange<std::size_t>(1, 10),
                                              rc::gen::inRange('0', static_cast<char>('9' + 1)));
    };
    const std::string text = *rc::gen::element<std::string>("", "-") + digits() +
                             *rc::gen::element<std::string>("", "." + digits());
    double expected = 0.0;
    RC_ASSERT(parse_number(text, expected) == NumberText::kNumber);
    if (const auto found = number(text))
      RC_ASSERT(std::bit_cast<std::uint64_t>(*found) == std::bit_cast<std::uint64_t>(expected));
    std::int64_t whole = 0;
    if (const auto found = integer(text)) RC_ASSERT(parse_integer(text, whole) && whole == *found);
  }));
}

TEST(PlainNumber, RefusesEveryOtherByteEverywhere) {
  for (int byte = 0; byte < 256; ++byte) {
    if (byte >= '0' && byte <= '9') continue;
    for (std::size_t at = 1; at < 8; ++at) {
      std::string text = "12345678";
      text[at] = static_cast<char>(byte);
      EXPECT_EQ(integer(text), std::nullopt) << byte;
      if (byte != '.') EXPECT_EQ(number(text + ".5"), std::nullopt) << byte;
      if (byte != '.') EXPECT_EQ(number("5." + text), std::nullopt) << byte;
    }
  }
}

}  // namespace plain_number_test
}  // namespace octant::io
