// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/csv_scan.h"

#include <algorithm>

#include "tests/io/io_support.h"

namespace octant::io {
namespace csv_scan_test {

/// Bytes that differ from separators by a bit or by a borrow: where a word's trick would go wrong.
std::string some_bytes() {
  return *rc::gen::container<std::string>(
      rc::gen::weightedOneOf<char>({{4, rc::gen::element('1', 'a', ' ', '\t', '\r', '+', '-', '.', '\x0B',
                                                         '\x09', '\xAC', '\x8A', '\0', '\x80', '\x01')},
                                    {1, rc::gen::element(',', '\n')},
                                    {2, rc::gen::arbitrary<char>()}}));
}

TEST(CsvScan, FindsTheFirstSeparatorAsALoopOverTheBytesDoes) {
  EXPECT_TRUE(rc::check("from anywhere", [] {
    const std::string text = some_bytes();
    const char *begin = text.data(), *end = begin + text.size();
    for (const char* from = begin; from <= end; ++from) {
      const char* expected = std::find_if(from, end, [](char c) { return c == ',' || c == '\n'; });
      RC_ASSERT(find_separator(from, end) == expected);
    }
  }));
}

TEST(CsvScan, NothingBehindTheEndIsLookedAt) {
  const std::string text = "abcdefg,hijk";
  for (std::size_t length = 0; length <= 7; ++length)
    EXPECT_EQ(find_separator(text.data(), text.data() + length), text.data() + length) << length;
  EXPECT_EQ(find_separator(text.data(), text.data() + 8), text.data() + 7);
}

TEST(CsvScan, AWordsMatchesAreExactUpToTheFirst) {
  EXPECT_TRUE(rc::check("against the bytes one by one", [] {
    const auto word = *rc::gen::arbitrary<std::uint64_t>();
    const auto c = static_cast<unsigned char>(*rc::gen::oneOf(
        rc::gen::arbitrary<std::uint8_t>(), rc::gen::just(static_cast<std::uint8_t>(word >> 24))));
    int first = 8;
    for (int i = 7; i >= 0; --i)
      if (static_cast<unsigned char>(word >> (8 * i)) == c) first = i;
    const std::uint64_t found = matches(word, c);
    RC_ASSERT((found == 0) == (first == 8));
    if (found != 0) RC_ASSERT(std::countr_zero(found) == 8 * first + 7);
  }));
}

TEST(CsvScan, BlanksRoundAFieldAreNoneOfIt) {
  const auto trim = [](const std::string& text) {
    return std::string(trimmed(text.data(), text.data() + text.size()));
  };
  EXPECT_EQ(trim("  a b\t\r"), "a b");
  EXPECT_EQ(trim(" \t\r "), "");
  EXPECT_EQ(trim(""), "");
  EXPECT_EQ(trim("\va\n"), "\va\n") << "no other white space";
}

}  // namespace csv_scan_test
}  // namespace octant::io
