// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/import/column_rules.h"
#include "models/support/result.h"

// Conversion of a table of times of flight or distances to tof.csv: `octant convert --columns`.
namespace octant::io {

/// "time=timestamp_ms*1e-3,beacon=anchor,distance=distance_cm*1e-2". Targets may go without their unit.
/// Tables with one column for each beacon: "distance=r_{beacon}" or "distance:A1=r1,distance:A2=r2" (with a
/// receiver: distance:A1:front=...). Tables without a header line: "time=#1,distance:A1=#2".
/// Errors: kUsage, naming the word.
[[nodiscard]] Result<TableMapping> mapping_from_words(std::string_view words);
/// Reads a mapping from a file: octant_columns: 1, columns: {time_s: ..., distance_m: ... or {A1: ...}},
/// ignore: [...].
[[nodiscard]] Result<TableMapping> read_mapping(const std::string& path);
/// Mapping of a table whose header has the names of tof.csv; no value for other tables.
[[nodiscard]] std::optional<TableMapping> mapping_of_header(const std::string& path);
[[nodiscard]] std::string mapping_to_yaml(const TableMapping& mapping);

/// Describes how a table would be read with --columns, with the names of its columns; empty for files that
/// are no tables.
[[nodiscard]] std::string advice_for_table(const std::string& path);

/// Result of converting a table.
struct ConvertedTable {
  std::string csv;  ///< of tof.csv
  std::size_t rows = 0, ignored = 0, dropped = 0;
  std::size_t not_heard = 0;  ///< empty cells in columns of one beacon
  char delimiter = ',';
  bool decimal_comma = false;
  std::vector<std::string> warnings;
};

/// Reads a table. Delimiter (comma, semicolon, tabulator, bar, blanks) and decimal commas are recognised. A
/// clock that starts again is continued, rows that are not in the order of time are sorted, rows without a
/// beacon are dropped, each with a warning. Errors: kBadInput with line and column: columns that are missing,
/// units that are not known, cells that are no numbers.
[[nodiscard]] Result<ConvertedTable> convert_table(const std::string& path, const TableMapping& mapping);

}  // namespace octant::io
