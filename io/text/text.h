// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "models/physics/attenuation.h"
#include "models/support/result.h"

namespace octant::io {

/// Text for a message: in single quotes, without control characters, truncated after some 40 characters.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// Names among the candidates that may be meant, as a sentence: "did you mean 'B9' or 'B10'?"; otherwise
/// "known: B0, B1, ... (12 in all)"; empty without candidates.
[[nodiscard]] std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

/// "a, b, c" of at most `most` items, with "... (n in all)" behind.
[[nodiscard]] std::string listed(const std::vector<std::string>& items, std::size_t most = 8);

/// Text without surrounding blanks and carriage returns.
[[nodiscard]] std::string_view without_blanks(std::string_view text);
/// Removes the first line from a text and returns it, without its newline.
std::string_view take_line(std::string_view& text);
/// ASCII letters in lower case.
[[nodiscard]] std::string lower_case(std::string_view text);
/// A CSV field, in quotes if necessary.
[[nodiscard]] std::string csv_field(std::string_view text);

/// Shortest decimal text that reads back as the same double.
[[nodiscard]] std::string exact(double value);
/// A number as a field of a table; empty if it is not finite.
[[nodiscard]] std::string number_field(double value);

inline constexpr const char* kExpectedLength = "metres, at most 1e9";  ///< kLargestLength_m

enum class NumberText { kNumber, kEmpty, kNotNumber };
/// Whole text as a decimal number ("nan" and "inf" are numbers too); a leading '+' is allowed, hexadecimal is
/// not.
[[nodiscard]] NumberText parse_number(std::string_view text, double& value);

/// Whole text as a whole number; "7.0" counts as one. Beyond 2^53 only where there are digits alone.
[[nodiscard]] bool parse_integer(std::string_view text, std::int64_t& value);

struct TextPosition {
  int line = 1;
  int column = 1;
};
/// Line and column (in bytes), both from 1, of an offset.
[[nodiscard]] TextPosition position_of(std::string_view text, std::size_t offset);

/// The text without a leading byte-order mark.
[[nodiscard]] std::string_view without_bom(std::string_view text);

/// Returns true if the text is UTF-8 without a NUL.
[[nodiscard]] bool is_utf8(std::string_view text);

/// Errors: kBadInput with line and column where the text is not UTF-8 or holds a NUL.
[[nodiscard]] Result<void> check_utf8(std::string_view text, const std::string& file);

/// Allowed values of a number; `words` describes them in messages ("a positive number").
struct NumberRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false;
  const char* words = "a number";
  [[nodiscard]] constexpr bool contains(double value) const {
    return value >= low && value <= high && !(low_excluded && value == low);
  }
};
inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kPositive{.low = 0.0, .low_excluded = true, .words = "a positive number"};
inline constexpr NumberRange kNotNegative{.low = 0.0, .words = "zero or a positive number"};
inline constexpr NumberRange kFraction{.low = 0.0, .high = 1.0, .words = "a fraction from 0 to 1"};
inline constexpr NumberRange kHalfPowerAngle{
    .low = kLeastHalfPowerAngle_rad,
    .high = kMostHalfPowerAngle_rad,
    .words = "an angle off the axis from 0.02 to 2.8 rad (half of the beam width at -3 dB)"};
inline constexpr NumberRange kCelsius{
    .low = -100.0, .high = 100.0, .words = "degrees Celsius from -100 to 100 (20 degC are 293 K)"};
inline constexpr NumberRange kRelativeHumidity{
    .low = 0.0, .high = 1.0, .words = "a fraction from 0 to 1 (50 % is 0.5)"};
inline constexpr NumberRange kPascals{
    .low = 1.0e4, .high = 1.0e7, .words = "pascals, such as 101325 (1013 hPa are 101300)"};

}  // namespace octant::io
