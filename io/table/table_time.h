// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: times of a table.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/table/column_unit.h"
#include "io/table/table_cells.h"
#include "io/text/time_text.h"
#include "io/tof/continued_clock.h"

namespace octant::io {

/// Conversion of the cells of a column of times to seconds.
struct TimeColumn {
  UnitConversion unit;
  DateOrder order = DateOrder::kNone;
  std::optional<ClockPeriod> clock;  ///< of a clock that is known to start again
  std::string format;     ///< of kTimeFormats, as the cells have it; empty: the name or the mapping states it
  std::string words;      ///< for people: "milliseconds", "dates and times without a zone, used as UTC"
  bool is_stamp = false;  ///< a time since 1970 in milliseconds, microseconds or nanoseconds
  bool guessed = false;   ///< neither the name nor the mapping states the format

  /// Seconds of a cell; no value if it is neither a number nor a time.
  [[nodiscard]] std::optional<double> seconds(std::string_view cell, DecimalMark decimal) const;
};

/// Finds the format of times.
/// @param name    of the column; empty without a header line
/// @param cells   the first cells
/// @param stated  of kTimeFormats, or empty
/// @param factor  of the mapping
/// @param guess   a unit that neither the name nor the mapping states is guessed from the steps of the times;
///                that of times beyond the year 2100 always
[[nodiscard]] Result<TimeColumn> time_column(std::string_view name, const std::vector<std::string>& cells,
                                             DecimalMark decimal, std::string_view stated,
                                             std::optional<double> factor, bool guess);

/// factor * value. A factor such as 1e-3 divides, so that 50 ms are 0.05 s to the last digit.
[[nodiscard]] double scaled(double value, double factor);

}  // namespace octant::io
