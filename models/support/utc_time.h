// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace octant {

/// Seconds since 1970 of a date in ISO 8601: "2026-11-22T10:27:37Z", with a fraction (left out) or an offset
/// (+01:00), or the day alone (its midnight). None where it is something else, or no day of the calendar.
[[nodiscard]] std::optional<std::int64_t> utc_seconds(std::string_view text);
/// "2026-11-22T10:27:37Z".
[[nodiscard]] std::string utc_text(std::int64_t seconds);

}  // namespace octant
