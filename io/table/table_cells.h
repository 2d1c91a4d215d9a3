// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io: cells of a table, and the columns that a mapping names.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/table/table_mapping.h"
#include "io/tof_columns.h"

namespace octant::io {

/// Column of tof.csv with this name or short name; null if there is no such column.
[[nodiscard]] const TofColumn* tof_column(std::string_view name);

/// Cells of one line. Quotes as in RFC 4180; several blanks are one delimiter.
/// @param open  set to true if a quote does not end on the line
[[nodiscard]] std::vector<std::string> cells_of(std::string_view line, char delimiter, bool* open = nullptr);

/// Mark before the decimals. kEither: a single comma or point; of two marks the last one.
enum class DecimalMark { kPoint, kComma, kEither };

/// A number with the mark, with thousands separated ("1.234,5", "1 234.5", "1'234"), or in hexadecimal
/// (0x1F). May be NaN or infinite.
[[nodiscard]] bool cell_number(std::string_view text, DecimalMark mark, double& value);
/// The mark that the numbers among the cells have; kEither if they have both or none.
[[nodiscard]] DecimalMark decimal_mark(const std::vector<std::vector<std::string>>& rows);
/// True for words without a measurement: an empty cell, "nan", "n/a", "-", "null", "timeout", ...
[[nodiscard]] bool is_no_value(std::string_view cell);
/// True if the cell is a number, a time or without a measurement.
[[nodiscard]] bool is_numeric(std::string_view cell, DecimalMark mark);

/// True for the source of tof_s or distance_m that is a pattern, "r_{beacon}".
[[nodiscard]] inline bool is_pattern(const ColumnRule& rule) {
  return rule.source.find('{') != std::string::npos &&
         (rule.target == "tof_s" || rule.target == "distance_m");
}
/// True for a rule whose column belongs to one beacon, or whose pattern names the beacons.
[[nodiscard]] inline bool names_beacon(const ColumnRule& rule) {
  return !rule.beacon.empty() || is_pattern(rule);
}
/// Index of a column that is named by its number, "#1"; -1 for other sources.
[[nodiscard]] int numbered_column(std::string_view source);
/// True for a rule whose column is named by its number.
[[nodiscard]] bool is_numbered(const ColumnRule& rule);
/// True if the column may be what a rule names: by its number, its name or its pattern.
[[nodiscard]] bool is_source(const ColumnRule& rule, std::string_view name, std::size_t index);
/// Names of the two columns of "Date+Time"; the second is empty for other sources.
[[nodiscard]] std::pair<std::string_view, std::string_view> date_and_time(std::string_view source);

}  // namespace octant::io
