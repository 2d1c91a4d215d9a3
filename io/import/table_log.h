// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "models/support/result.h"

// Any table of times of flight or distances as a tof.csv: `octant convert --columns`.
namespace octant::io {

/// A column of tof.csv out of one of the table: target = factor * source + offset; ids are taken as they
/// stand.
struct ColumnRule {
  std::string
      target;  ///< time_s, beacon, tof_s, distance_m, epoch, vehicle, receiver, amplitude_v, temperature_degC
  std::string source;
  double factor = 1.0;
};

struct TableMapping {
  std::vector<ColumnRule> columns;
  std::vector<std::string> ignore;  ///< beacons whose rows are left out, those of a neighbour
};

/// "time=timestamp_ms*1e-3,beacon=anchor,distance=distance_cm*1e-2". Targets may go without their unit. A
/// source without a factor whose name ends in a unit (_ms, _us, _ns, _cm, _mm, _km, _ft, _mv) gets that
/// unit's. Errors: kUsage, naming the word.
[[nodiscard]] Result<TableMapping> mapping_from_words(std::string_view words);
/// The same as a file: octant_columns: 1, columns: {time_s: ..., ...}, ignore: [...].
[[nodiscard]] Result<TableMapping> read_mapping(const std::string& path);
/// The mapping of a table whose header has the names of tof.csv; none: it has not, or cannot be read.
[[nodiscard]] std::optional<TableMapping> mapping_of_header(const std::string& path);
[[nodiscard]] std::string mapping_to_yaml(const TableMapping& mapping);

/// What a table became.
struct ConvertedTable {
  std::string csv;  ///< of tof.csv
  std::size_t rows = 0, ignored = 0, dropped = 0;
  char delimiter = ',';
  bool decimal_comma = false;
  std::vector<std::string> warnings;
};

/// Reads a table with one header row; delimiter (comma, semicolon, tabulator, bar, blanks) and decimal commas
/// are found out. Rows that run backwards in time are put in order, rows without a beacon are dropped, with a
/// warning. Errors: kBadInput with line and column: columns that there are not, cells that are no numbers.
[[nodiscard]] Result<ConvertedTable> convert_table(const std::string& path, const TableMapping& mapping);

}  // namespace octant::io
