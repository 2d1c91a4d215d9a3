// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: times as programs write them into text.

#include <optional>
#include <string_view>

namespace octant::io {

/// Meaning of dates such as 6/11/2026. Without an order they are no dates.
enum class DateOrder { kNone, kDayFirst, kMonthFirst };

/// Seconds of a number, a date with a time, or a time of day:
///   12.5    2026-06-11 11:33:48.686    2026-06-11T11:33:48Z    20260611T113348Z    11.06.2026 11:33
///   11-Jun-2026 11:33:48    6/11/2026 1:33:48 PM    11:33:48,686
/// Dates count from 1970-01-01 UTC; an offset (+02:00) is subtracted, and a date without one is in UTC. No
/// value for all other text and for numbers that are not finite.
[[nodiscard]] std::optional<double> time_of_text(std::string_view text, DateOrder order = DateOrder::kNone);

/// Returns true if the text is a date without a time (`2026-06-11`), as tables have it in a column of its
/// own.
[[nodiscard]] bool is_date(std::string_view text);

/// Seconds of a time stamp. Numbers beyond 1e11 s (the year 5138) are stamps since 1970 in milliseconds,
/// microseconds or nanoseconds, which their size distinguishes.
[[nodiscard]] double seconds_of_stamp(double stamp);

}  // namespace octant::io
