// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: times as programs write them into text.

#include <optional>
#include <string_view>

namespace octant::io {

/// Seconds of a number, a date with a time, or a time of day:
///   12.5    2026-06-11 11:33:48.686    2026-06-11T11:33:48Z    11.06.2026 11:33:48    11:33:48,686
/// Dates count from 1970-01-01 UTC; an offset (+02:00) is subtracted, and a date without one is in UTC. No
/// value for all other text and for numbers that are not finite.
[[nodiscard]] std::optional<double> time_of_text(std::string_view text);

/// Seconds of a time stamp. Numbers beyond 1e11 s (the year 5138) are stamps since 1970 in milliseconds,
/// microseconds or nanoseconds, which their size distinguishes.
[[nodiscard]] double seconds_of_stamp(double stamp);

}  // namespace octant::io
