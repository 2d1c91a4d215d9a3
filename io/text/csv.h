// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: reader of CSV (RFC 4180) from a text in memory.

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/text/text.h"
#include "models/support/result.h"

namespace octant::io {

/// Reads the rows of a CSV text once. Fields are views into the text, and only quoted fields with doubled
/// quotes are copied. The text must outlive the reader.
///   CsvReader csv(text, "run/tof.csv");
///   const int t = csv.require("time_s");
///   while (csv.next_row()) csv.number(t, ...);
///   if (csv.error()) ...
/// The first error is kept; next_row() then returns false.
class CsvReader {
 public:
  /// Reads the header row. Refuses what is not UTF-8, empty files, other separators than the comma, columns
  /// given twice.
  /// @param checked  the caller sees to it that the text is UTF-8
  CsvReader(std::string_view text, std::string file, bool checked = false);

  /// As messages name it.
  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }
  /// Index of a column, -1 if it is missing; marks the column as known.
  int find(std::string_view name);
  /// Index of a required column. If it is missing, the error names all missing columns so far and columns
  /// that may be meant.
  int require(std::string_view name);
  /// For columns that are known by a pattern of names: the caller has seen this one.
  void mark_known(std::size_t column) { known_[column] = true; }
  /// One warning about the columns that were not requested.
  [[nodiscard]] std::optional<std::string> unknown_columns() const;

  /// Next row that is not blank; false at the end and on error.
  bool next_row();
  /// Line in which the current row begins.
  [[nodiscard]] int line() const { return row_line_; }
  /// Field of the current row without blanks around it; empty for column -1.
  [[nodiscard]] std::string_view field(int column) const {
    return column < 0 ? std::string_view() : fields_[static_cast<std::size_t>(column)];
  }
  /// Where the next row begins: how many bytes of the text (its byte-order mark included) have been read.
  [[nodiscard]] std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
  [[nodiscard]] int next_line() const { return line_; }
  /// Goes on at an offset, at which a row of that line begins.
  void go_to(std::size_t offset, int line) {
    at_ = begin_ + offset;
    line_ = line;
  }
  /// A guess at how many rows are left, from the length of the first ones: for reserve().
  [[nodiscard]] std::size_t rows_left_estimate() const;

  // Typed fields; false after logging an error.
  /// Any number, empty and nan (value NaN) and inf included.
  bool number_or_nan(int column, double& value);
  /// A finite number.
  bool number(int column, double& value);
  /// A finite number in metres, at most kLargestLength_m.
  bool length(int column, double& metres);
  /// Checks that an angle is within one turn (NaN passes).
  bool check_angle(int column, double angle_rad);
  /// A whole number; "7.0" counts as one.
  bool integer(int column, std::int64_t& value);

  [[nodiscard]] const std::optional<Error>& error() const { return error_; }
  /// Logs an error of the current row, at a column (-1: the row as a whole), unless there is one already.
  /// Returns false.
  bool fail_at(int column, std::string found, std::string expected, std::string advice = "");
  /// "run/tof.csv:8" of the current row.
  [[nodiscard]] std::string place() const;

 private:
  void read_header();
  bool read_fields();
  const char* read_quoted(const char* at);
  bool check_count();
  [[nodiscard]] int column_in_line(const char* at) const;
  void skip_comments();
  void check_separator(std::string_view line);
  bool fail_long(int line);
  /// Two billion lines are counted as that many.
  void next_line_of_file() { line_ += static_cast<int>(line_ < std::numeric_limits<int>::max()); }
  bool not_a_number(int column, const char* expected);
  [[nodiscard]] std::string renamed_columns() const;
  [[nodiscard]] std::string convert_advice(std::string_view columns) const;
  void fail_file(int line, std::string found, std::string expected, std::string advice = "");

  std::string file_;
  const char* begin_;
  const char* at_;
  const char* end_;
  int line_ = 1;               // of at_
  int row_line_ = 1;           // of the current row
  const char* row_ = nullptr;  // begin of the current row
  std::vector<std::string> header_;
  std::vector<bool> known_;
  std::vector<std::string> asked_;
  std::vector<std::string> missing_;  // of those that are required
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;  // fields of the current row that had doubled quotes
  std::vector<std::pair<std::size_t, int>>
      quoted_columns_;  // quoted fields of the current row and their columns in the line
  std::optional<Error> error_;
};

}  // namespace octant::io
