// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/import/imported_log.h"
#include "io/table/table_mapping.h"
#include "models/support/result.h"

// Tables of times of flight or distances as people have them: `octant convert`.
namespace octant::io {

struct TableLog {
  ImportedLog log;
  TableMapping mapping;  ///< as stated, or as guessed
  /// One line for each property of the table: "time: column 'when', dates and times".
  std::vector<std::string> understood;
  std::vector<std::string> guessed;  ///< the lines about what was guessed, with the option that overrules it
};

/// Reads a table: text in an encoding and compression of decoded_text.h, with or without a header line, with
/// a beacon's name in each row or with a column for each beacon. Delimiter (comma, semicolon, tabulator, bar,
/// blanks), decimal commas, header line, format of times and cells without a measurement are recognised, and
/// so are the columns if the mapping has none. Lines that are no rows (messages of a device, header lines
/// again), rows without a beacon, and rows that do not meet the conditions are left out, counted in a
/// warning. Errors: kBadInput with line and column: columns that are missing or not recognised, units that
/// are not known, cells that are no numbers.
[[nodiscard]] Result<TableLog> read_table_log(const std::string& path, const TableMapping& mapping);

}  // namespace octant::io
