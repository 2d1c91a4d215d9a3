// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the smallest steps over a CSV text.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace octant::io {

/// A byte of 0x80 for each byte of the word that equals c; exact at least up to the first of them.
inline std::uint64_t matches(std::uint64_t word, std::uint64_t c) {
  const std::uint64_t x = word ^ (0x0101010101010101ULL * c);
  return (x - 0x0101010101010101ULL) & ~x & 0x8080808080808080ULL;
}

/// First comma or newline in [p, end), eight bytes at a time.
inline const char* find_separator(const char* p, const char* end) {
  static_assert(std::endian::native == std::endian::little);
  while (end - p >= 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, p, 8);
    // Both masks are exact up to their first bit, so the lower first bit is exact.
    const std::uint64_t commas = matches(word, ','), newlines = matches(word, '\n');
    if ((commas | newlines) != 0) return p + std::countr_zero(commas | newlines) / 8;
    p += 8;
  }
  while (p != end && *p != ',' && *p != '\n') ++p;
  return p;
}

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

inline std::string_view trimmed(const char* begin, const char* end) {
  while (begin != end && is_blank(*begin)) ++begin;
  while (begin != end && is_blank(end[-1])) --end;
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace octant::io
