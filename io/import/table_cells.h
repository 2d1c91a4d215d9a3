// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io: cells of a table, and the columns that a mapping names.

#include <string>
#include <string_view>
#include <vector>

#include "io/import/column_rules.h"
#include "io/tof_columns.h"

namespace octant::io {

/// Column of tof.csv with this name or short name; null if there is no such column.
[[nodiscard]] const TofColumn* tof_column(std::string_view name);

/// Cells of one line. Quotes as in RFC 4180; several blanks are one delimiter.
/// @param open  set to true if a quote does not end on the line
[[nodiscard]] std::vector<std::string> cells_of(std::string_view line, char delimiter, bool* open = nullptr);

/// The delimiter by which the header has all columns of the mapping; among several, the one with most cells.
[[nodiscard]] char delimiter_of(std::string_view header, const TableMapping& mapping);

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

/// True if the cells of a first line are numbers, times or empty: the table has no header line.
[[nodiscard]] bool is_headless(const std::vector<std::string>& cells);

}  // namespace octant::io
