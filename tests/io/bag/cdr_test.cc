// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/cdr.h"

#include <algorithm>
#include <type_traits>
#include <variant>

#include "tests/io/io_support.h"

namespace octant::io {
namespace cdr_test {

using Field =
    std::variant<std::uint8_t, std::int16_t, std::uint32_t, std::int64_t, float, double, std::string>;

Field some_field() {
  switch (*rc::gen::inRange(0, 7)) {
    case 0: return *rc::gen::arbitrary<std::uint8_t>();
    case 1: return *rc::gen::arbitrary<std::int16_t>();
    case 2: return *rc::gen::arbitrary<std::uint32_t>();
    case 3: return *rc::gen::arbitrary<std::int64_t>();
    case 4: return static_cast<float>(*rc::gen::inRange(-1000, 1000)) / 8;
    case 5: return test::some_number();
    default: return *rc::gen::container<std::string>(rc::gen::inRange('a', 'z'));
  }
}

/// The encoding byte by byte as in OMG's standard: a number begins at a multiple of its size after the four
/// bytes of the head (in plain CDR2, at most four bytes); a text is its length with a NUL.
std::string encoded(const std::vector<Field>& fields, int kind) {
  std::string out;
  const bool little = kind % 2 == 1;
  const std::size_t most = kind >= 6 ? 4 : 8;
  const auto put = [&](const auto& number) {
    constexpr std::size_t kSize = sizeof(number);
    while (out.size() % std::min(kSize, most) != 0) out += '\xEE';  // padding may hold anything
    std::string bytes(reinterpret_cast<const char*>(&number), kSize);
    if (little != (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
    out += bytes;
  };
  for (const Field& field : fields) {
    if (const auto* text = std::get_if<std::string>(&field)) {
      put(static_cast<std::uint32_t>(text->size() + 1));
      out += *text + '\0';
    } else {
      std::visit(
          [&](const auto& value) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::string>) put(value);
          },
          field);
    }
  }
  return std::string("\0", 1) + static_cast<char>(kind) + std::string(2, '\0') + out;
}

bool reads(CdrReader& in, const Field& field) {
  if (const auto* text = std::get_if<std::string>(&field)) return in.text() == *text;
  return std::visit(
      [&](const auto& value) {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, std::string>)
          return false;
        else
          return in.value<T>() == value;
      },
      field);
}

TEST(Cdr, ReadsEveryEncodingThatThereIs) {
  EXPECT_TRUE(rc::check("both byte orders, CDR and plain CDR2", [] {
    std::vector<Field> fields;
    for (int i = *rc::gen::inRange(0, 12); i > 0; --i) fields.push_back(some_field());
    for (const int kind : {0, 1, 6, 7}) {
      const std::string message = encoded(fields, kind);
      CdrReader in(message);
      for (const Field& field : fields) RC_ASSERT(reads(in, field));
      RC_ASSERT(in.ok());
    }
  }));
}

TEST(Cdr, WritesLittleEndianCdr) {
  EXPECT_TRUE(rc::check("byte for byte, padding apart", [] {
    std::vector<Field> fields;
    for (int i = *rc::gen::inRange(0, 12); i > 0; --i) fields.push_back(some_field());
    CdrWriter out;
    for (const Field& field : fields)
      std::visit(
          [&](const auto& value) {
            if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::string>)
              out.text(value);
            else
              out.value(value);
          },
          field);
    std::string expected = encoded(fields, 1);
    RC_ASSERT(out.message().size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      if (expected[i] == '\xEE' && out.message()[i] == '\0') expected[i] = '\0';
    RC_ASSERT(out.message() == expected);
  }));
}

TEST(Cdr, AMessageThatEndsEarlyIsNotOkWhereverItEnds) {
  const std::vector<Field> fields = {std::uint8_t{7}, 1.5, std::string("hall"), std::uint32_t{9}, 2.5};
  const std::string whole = encoded(fields, 1);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CdrReader in(std::string_view(whole).substr(0, size));
    (void)in.value<std::uint8_t>(), (void)in.value<double>(), (void)in.text(),
        (void)in.value<std::uint32_t>();
    EXPECT_EQ(in.value<double>(), 0.0) << size;
    EXPECT_FALSE(in.ok()) << size;
    EXPECT_EQ(in.value<std::uint8_t>(), 0) << "and stays so";
    EXPECT_EQ(in.text(), "");
  }
}

TEST(Cdr, OtherEncodingsAreNotGuessed) {
  for (const int kind : {2, 3, 4, 5, 8, 10, 255}) {
    const std::string message = encoded({std::uint32_t{1}}, kind);
    CdrReader in(message);
    EXPECT_FALSE(in.ok()) << kind;
    EXPECT_EQ(in.value<std::uint32_t>(), 0U);
  }
  EXPECT_FALSE(CdrReader("").ok());
  EXPECT_FALSE(CdrReader(std::string_view("\1\1\0\0", 4)).ok());
}

TEST(Cdr, ASequenceIsNoLongerThanItsBytes) {
  CdrWriter out;
  out.value(std::uint32_t{3});
  for (int i = 0; i < 3; ++i) out.value(std::uint64_t{1});
  // Four bytes of padding precede the first: 28 bytes remain.
  EXPECT_EQ(CdrReader(out.message()).count(8), 3U);
  EXPECT_EQ(CdrReader(out.message()).count(9), 3U);
  CdrReader in(out.message());
  EXPECT_EQ(in.count(10), 0U);
  EXPECT_FALSE(in.ok());
  CdrWriter huge;
  huge.value(std::uint32_t{0xFFFFFFFF});
  EXPECT_EQ(CdrReader(huge.message()).count(1), 0U);
}

TEST(Cdr, ATextEndsAtItsNul) {
  CdrWriter out;
  out.value(std::uint32_t{6});
  for (const char c : {'a', 'b', '\0', 'c', 'd', '\0'}) out.value(c);
  out.value(std::uint8_t{5});
  CdrReader in(out.message());
  EXPECT_EQ(in.text(), "ab");
  EXPECT_EQ(in.value<std::uint8_t>(), 5) << "and the next field stands behind all of it";
  CdrWriter none;
  none.value(std::uint32_t{0});  // some writers leave the NUL out where there is no text
  CdrReader empty(none.message());
  EXPECT_EQ(empty.text(), "");
  EXPECT_TRUE(empty.ok());
}

}  // namespace cdr_test
}  // namespace octant::io
