// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace octant {

/// Length of the mean calendar month, for ages and due dates.
inline constexpr double kSecondsAMonth = 30.44 * 86400.0;

/// Parses a date in ISO 8601 into seconds since 1970: "2026-11-22T10:27:37Z", with an optional fraction
/// (ignored) or offset (+01:00), or the day alone (midnight). No value if the text is not a valid date.
[[nodiscard]] std::optional<std::int64_t> utc_seconds(std::string_view text);
/// Formats a time as "2026-11-22T10:27:37Z".
[[nodiscard]] std::string utc_text(std::int64_t seconds);

}  // namespace octant
