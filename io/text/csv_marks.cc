// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/csv_marks.h"

#include <bit>
#include <cstddef>
#include <string>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace octant::io {
namespace {

constexpr std::size_t kBlock = 64;
constexpr std::uint64_t kNeverZero =
    std::uint64_t{1} << 63;  // spares a branch, and is nobody's first mark but the last byte's

/// Marks of a block of 64 bytes: a bit for each; unusual bytes of all blocks so far are collected in `odd`.
#ifdef __SSE2__
struct Odd {
  __m128i quote = _mm_setzero_si128(), nul = _mm_setzero_si128(), high = _mm_setzero_si128();
  [[nodiscard]] bool quotes() const { return _mm_movemask_epi8(quote) != 0; }
  [[nodiscard]] bool nuls() const { return _mm_movemask_epi8(nul) != 0; }
  [[nodiscard]] bool highs() const { return _mm_movemask_epi8(high) != 0; }
};

std::uint64_t marks_of(const char* block, Odd& odd) {
  const auto equal = [](__m128i bytes, char c) { return _mm_cmpeq_epi8(bytes, _mm_set1_epi8(c)); };
  std::uint64_t marks = 0;
  for (int i = 0; i < 4; ++i) {
    const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(block + 16 * i));
    const __m128i found =
        _mm_or_si128(_mm_or_si128(equal(bytes, ','), equal(bytes, '.')), equal(bytes, '\n'));
    odd.quote = _mm_or_si128(odd.quote, equal(bytes, '"'));
    odd.nul = _mm_or_si128(odd.nul, equal(bytes, '\0'));
    odd.high = _mm_or_si128(odd.high, bytes);
    marks |= static_cast<std::uint64_t>(static_cast<unsigned>(_mm_movemask_epi8(found))) << (16 * i);
  }
  return marks;
}
#else
struct Odd {
  bool quote = false, nul = false, high = false;
  [[nodiscard]] bool quotes() const { return quote; }
  [[nodiscard]] bool nuls() const { return nul; }
  [[nodiscard]] bool highs() const { return high; }
};

std::uint64_t marks_of(const char* block, Odd& odd) {
  std::uint64_t marks = 0;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const char c = block[i];
    odd.quote |= c == '"';
    odd.nul |= c == '\0';
    odd.high |= (static_cast<unsigned char>(c) & 0x80) != 0;
    marks |= static_cast<std::uint64_t>(c == ',' || c == '.' || c == '\n') << i;
  }
  return marks;
}
#endif

/// Bits that are set; the processors that all programs must run on have no instruction for it.
std::size_t number_of(std::uint64_t bits) {
  bits -= (bits >> 1) & 0x5555555555555555ULL;
  bits = (bits & 0x3333333333333333ULL) + ((bits >> 2) & 0x3333333333333333ULL);
  return static_cast<std::size_t>((((bits + (bits >> 4)) & 0x0F0F0F0F0F0F0F0FULL) * 0x0101010101010101ULL) >>
                                  56);
}

}  // namespace

void CsvMarks::find(std::string_view text) {
  Odd odd;
  count = 0;
  std::size_t at = 0;
  const auto keep = [&](std::uint64_t marks) {
    if (offsets.size() < count + kBlock) offsets.resize(2 * count + 1024);
    std::uint32_t* out = offsets.data() + count;
    count += number_of(marks);
    // Always writes eight at a time, which is faster than a loop over an unpredictable number of marks
    // (simdjson).
    for (; marks != 0; out += 8) {
      for (int i = 0; i < 8; ++i, marks &= marks - 1)
        out[i] =
            static_cast<std::uint32_t>(at) + static_cast<std::uint32_t>(std::countr_zero(marks | kNeverZero));
    }
  };
  for (; at + kBlock <= text.size(); at += kBlock) keep(marks_of(text.data() + at, odd));
  if (at < text.size()) {
    std::string rest(text.substr(at));
    rest.resize(kBlock, ' ');
    keep(marks_of(rest.data(), odd));
  }
  has_quote = odd.quotes();
  has_nul = odd.nuls();
  has_high = odd.highs();
}

}  // namespace octant::io
