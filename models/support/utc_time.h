// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace octant {

/// The mean month of calendars, by which ages and due dates count.
inline constexpr double kSecondsAMonth = 30.44 * 86400.0;

/// Seconds since 1970 of a date in ISO 8601: "2026-11-22T10:27:37Z", with a fraction (left out) or an offset
/// (+01:00), or the day alone (its midnight). None where it is something else, or no day of the calendar.
[[nodiscard]] std::optional<std::int64_t> utc_seconds(std::string_view text);
/// "2026-11-22T10:27:37Z".
[[nodiscard]] std::string utc_text(std::int64_t seconds);

}  // namespace octant
