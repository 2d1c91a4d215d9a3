// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: lines and columns of a table.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/table/table_cells.h"
#include "models/support/result.h"

namespace octant::io {

/// Error of a table (kBadInput) at a line.
[[nodiscard]] inline tl::unexpected<Error> table_error(const std::string& path, int line, std::string found,
                                                       std::string expected, std::string advice = "") {
  return fail({.code = Errc::kBadInput,
               .file = path,
               .line = line,
               .found = std::move(found),
               .expected = std::move(expected),
               .advice = std::move(advice)});
}

/// Lines of a text that are neither blank nor comments (# or %), with their numbers.
class TableLines {
 public:
  explicit TableLines(std::string_view text) : rest_(text) {}

  /// Next line; false at the end. @param comments  receives the comments before it
  bool next(std::string_view& line, std::vector<std::pair<int, std::string_view>>* comments = nullptr);
  [[nodiscard]] int number() const { return number_; }
  /// Delimiter that a first line `sep=;` states, as spreadsheets write it.
  [[nodiscard]] std::optional<char> stated_delimiter() const { return delimiter_; }

 private:
  std::string_view rest_;
  int number_ = 0;
  std::optional<char> delimiter_;
};

struct TableLayout {
  char delimiter = ',';
  DecimalMark decimal = DecimalMark::kEither;
  int header_line = 0;                         ///< 0: the table has no header line
  int first_row_line = 0;                      ///< 0: the table has no rows
  std::size_t lines_before = 0;                ///< lines before the table that are no part of it
  std::string first_before;                    ///< the first of them
  std::vector<std::string> names;              ///< of the columns; "#1", "#2", ... without a header line
  std::vector<std::vector<std::string>> rows;  ///< cells of the first rows
};

/// Error of a line with an odd number of quotes.
[[nodiscard]] Error open_quote(const std::string& path, int line);

/// Finds delimiter, decimal mark, header line and first row from the first lines. Columns that the mapping
/// names identify the header line. Errors: kBadInput: an empty table; a quote that does not end on its line.
[[nodiscard]] Result<TableLayout> find_layout(std::string_view text, const std::string& path,
                                              const TableMapping& mapping);

}  // namespace octant::io
