// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Limits of texts from outside, checked before parsing. A text beyond them is refused as early as possible.

#include <cstddef>
#include <string>
#include <string_view>

#include "models/support/result.h"

namespace octant::io {

inline constexpr std::size_t kLargestYaml = std::size_t{16} << 20;      ///< bytes of a file
inline constexpr std::size_t kLongestLine = std::size_t{1} << 20;       ///< bytes, of CSV and logs
inline constexpr std::size_t kDeepestJson = 64;                         ///< brackets
inline constexpr std::size_t kMostJsonValues = std::size_t{1} << 27;    ///< most are a covariance's
inline constexpr std::size_t kMostJsonMembers = std::size_t{1} << 22;   ///< texts, keys, lists and objects
inline constexpr std::size_t kLongestJsonText = std::size_t{32} << 20;  ///< bytes in quotes

/// Errors: kBadInput with the line where the text is not UTF-8, holds a NUL, or has a line of more than
/// kLongestLine, whichever comes first.
[[nodiscard]] Result<void> check_lines(std::string_view text, const std::string& file);

/// Errors: kBadInput with the line where a JSON text exceeds the bounds above. What lies within them need not
/// be JSON.
[[nodiscard]] Result<void> check_json(std::string_view text, const std::string& file);

/// A JSON document (it begins with a brace) within the bounds above, or any other text of at most
/// kLargestYaml. Errors: those, and those of read_file().
[[nodiscard]] Result<std::string> read_document(const std::string& path);

}  // namespace octant::io
