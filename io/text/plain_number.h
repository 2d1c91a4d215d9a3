// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: numbers as nearly all cells hold them, "12", "-0.0327". Everything else (exponents, nan,
// blanks, more digits than a double is sure to hold) is left to parse_number() and parse_integer(), which
// agree with these to the last bit.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace octant::io {

/// Number of bytes before the end of a number that must be readable.
inline constexpr std::size_t kBeforeNumber = 8;

namespace plain {

static_assert(std::endian::native == std::endian::little);

inline constexpr std::array<std::uint64_t, 9> kPowers = {1,      10,      100,      1000,     10000,
                                                         100000, 1000000, 10000000, 100000000};
inline constexpr std::array<double, 9> kDoublePowers = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8};
/// Masks of the last n of eight bytes.
inline constexpr std::array<std::uint64_t, 9> kLast = {0,
                                                       0xFFULL << 56,
                                                       0xFFFFULL << 48,
                                                       0xFFFFFFULL << 40,
                                                       0xFFFFFFFFULL << 32,
                                                       0xFFFFFFFFFFULL << 24,
                                                       0xFFFFFFFFFFFFULL << 16,
                                                       0xFFFFFFFFFFFFFFULL << 8,
                                                       ~0ULL};

/// The `count` (to 8) bytes before `end` less '0', zeros before them.
inline std::uint64_t bytes_before(const char* end, std::size_t count) {
  std::uint64_t word = 0;
  std::memcpy(&word, end - 8, 8);
  return (word ^ 0x3030303030303030ULL) & kLast[count];
}

/// Number of eight digits; false if one of the bytes is not a digit.
inline bool join(std::uint64_t bytes, std::uint64_t& value) {
  if ((((bytes + 0x7676767676767676ULL) | bytes) & 0x8080808080808080ULL) != 0) return false;
  // Digits are joined to pairs, fours and eights.
  bytes = bytes * 10 + (bytes >> 8);
  constexpr std::uint64_t kMask = 0x000000FF000000FFULL;
  value =
      ((bytes & kMask) * (100 + (1000000ULL << 32)) + ((bytes >> 16) & kMask) * (1 + (10000ULL << 32))) >> 32;
  return true;
}

/// Numbers of two groups of eight digits.
inline bool join(std::uint64_t first, std::uint64_t second, std::uint64_t& first_value,
                 std::uint64_t& second_value) {
#ifdef __SSE2__
  const __m128i digits = _mm_set_epi64x(static_cast<long long>(second), static_cast<long long>(first));
  const __m128i beyond = _mm_subs_epu8(digits, _mm_set1_epi8(9));
  if (_mm_movemask_epi8(_mm_cmpeq_epi8(beyond, _mm_setzero_si128())) != 0xFFFF) return false;
  const __m128i tens = _mm_mullo_epi16(_mm_and_si128(digits, _mm_set1_epi16(0xFF)), _mm_set1_epi16(10));
  const __m128i pairs = _mm_add_epi16(tens, _mm_srli_epi16(digits, 8));
  const __m128i fours = _mm_madd_epi16(pairs, _mm_set1_epi32(100 | 1 << 16));
  const __m128i eights = _mm_madd_epi16(_mm_packs_epi32(fours, fours), _mm_set1_epi32(10000 | 1 << 16));
  const auto both = static_cast<std::uint64_t>(_mm_cvtsi128_si64(eights));
  first_value = both & 0xFFFFFFFF;
  second_value = both >> 32;
  return true;
#else
  return join(first, first_value) && join(second, second_value);
#endif
}

}  // namespace plain

/// Reads [-]digits[.digits] from `begin` to `end`, up to eight digits on each side; false for all other text.
/// The result is exact: an integer up to 2^53 and a power of ten up to 10^8 are exact, so one division rounds
/// correctly (Clinger 1990).
/// @param point  position of the point; `end` without a point
inline bool read_plain_number(const char* begin, const char* point, const char* end, double& value) {
  const bool negative = *begin == '-';
  begin += negative;
  const auto whole = static_cast<std::size_t>(point - begin);
  if (whole - 1 >= 8) return false;
  std::uint64_t mantissa = 0, behind = 0;
  double magnitude = 0.0;
  if (point != end) {
    const auto fraction = static_cast<std::size_t>(end - point) - 1;
    if (fraction - 1 >= 8 ||
        !plain::join(plain::bytes_before(point, whole), plain::bytes_before(end, fraction), mantissa, behind))
      return false;
    mantissa = mantissa * plain::kPowers[fraction] + behind;
    if (mantissa > (1ULL << 53)) return false;
    magnitude = static_cast<double>(static_cast<std::int64_t>(mantissa)) / plain::kDoublePowers[fraction];
  } else {
    if (!plain::join(plain::bytes_before(end, whole), mantissa)) return false;
    magnitude = static_cast<double>(static_cast<std::int64_t>(mantissa));
  }
  value = negative ? -magnitude : magnitude;
  return true;
}

/// Reads [-]digits from `begin` to `end`, up to eight; false where it is anything else.
inline bool read_plain_integer(const char* begin, const char* end, std::int64_t& value) {
  const bool negative = *begin == '-';
  begin += negative;
  const auto count = static_cast<std::size_t>(end - begin);
  std::uint64_t magnitude = 0;
  if (count - 1 >= 8 || !plain::join(plain::bytes_before(end, count), magnitude)) return false;
  value = negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
  return true;
}

}  // namespace octant::io
