// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/last_row.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "io/text/csv_scan.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kRowsCompared = 64;
/// A writer that omits trailing zeros writes a last number that is shorter than n others in at most one of n
/// + 1 files.
constexpr std::size_t kRowsThatTell = 10;
/// A file may be larger than the memory: at most this part of its end is read, and lines are counted only in
/// files of at most that size.
constexpr std::size_t kEndLookedAt = std::size_t{1} << 18, kLinesCounted = std::size_t{1} << 26;

using Cells = std::vector<std::string_view>;

/// Fields of a row. A row with quotes is not examined.
Cells cells_of_row(std::string_view row, bool by_blanks) {
  Cells cells;
  const std::string_view separators = by_blanks ? " \t\r" : ",;\t";
  for (std::size_t at = 0;;) {
    if (by_blanks) at = std::min(row.find_first_not_of(separators, at), row.size());
    if (by_blanks && at == row.size()) return cells;
    const std::size_t stop = std::min(row.find_first_of(separators, at), row.size());
    cells.push_back(io::trimmed(row.data() + at, row.data() + stop));
    if (stop == row.size()) return cells;
    at = stop + 1;
  }
}

/// Complete rows with content above the last one, the nearest first.
std::vector<Cells> rows_above(std::string_view text, bool by_blanks) {
  std::vector<Cells> rows;
  if (text.size() > kEndLookedAt)
    text.remove_prefix(std::min(text.find('\n', text.size() - kEndLookedAt), text.size() - 1) + 1);
  while (!text.empty() && rows.size() < kRowsCompared) {
    text.remove_suffix(1);                           // the newline
    const std::size_t begin = text.rfind('\n') + 1;  // 0 where there is none
    const std::string_view row = io::trimmed(text.data() + begin, text.data() + text.size());
    if (!row.empty() && row.front() != '#') rows.push_back(cells_of_row(row, by_blanks));
    text = text.substr(0, begin);
  }
  return rows;
}

bool is_finite_number(std::string_view cell) {
  double value = 0.0;
  return parse_number(cell, value) == NumberText::kNumber && std::isfinite(value);
}

std::size_t decimals(std::string_view number) {
  const std::size_t point = number.find('.');
  return point == std::string_view::npos ? 0 : number.size() - point - 1;
}

/// Reason why the last cell seems to be truncated, from the cells above it in its column; empty if it does
/// not.
std::string why_cut(std::string_view cell, const Cells& above) {
  if (above.size() < kRowsThatTell || std::ranges::find(above, cell) != above.end()) return "";
  Cells numbers;
  std::ranges::copy_if(above, std::back_inserter(numbers), is_finite_number);
  if (numbers.size() < kRowsThatTell) {
    const bool begins_a_name =
        std::ranges::any_of(above, [&](std::string_view name) { return name.starts_with(cell); });
    return begins_a_name ? fmt::format("ends with {}, which is the beginning of others", in_quotes(cell))
                         : "";
  }
  double value = 0.0;
  if (parse_number(cell, value) == NumberText::kNumber && !std::isfinite(value)) return "";  // nan is whole
  std::size_t least = std::numeric_limits<std::size_t>::max(), shortest = least;
  for (const std::string_view number : numbers) {
    least = std::min(least, decimals(number));
    shortest = std::min(shortest, number.size());
  }
  const bool whole_numbers =
      std::ranges::all_of(numbers, [](std::string_view number) { return decimals(number) == 0; });
  if (whole_numbers ? cell.size() >= shortest : decimals(cell) >= least) return "";
  return fmt::format("ends with {}, which is shorter than all above it", in_quotes(cell));
}

}  // namespace

std::string_view without_cut_row(std::string_view text, const std::string& file,
                                 std::vector<std::string>& warnings) {
  if (text.empty() || text.back() == '\n' || text.back() == '\r') return text;
  const std::string_view end = text.substr(text.size() - std::min(text.size(), kEndLookedAt));
  const std::size_t newline = end.rfind('\n');
  if (newline == std::string_view::npos) return text;  // a header alone, or a line that is too long
  const std::size_t begin = text.size() - end.size() + newline + 1;
  const std::string_view row = io::trimmed(text.data() + begin, text.data() + text.size());
  if (row.empty() || row.front() == '#') return text;
  const bool by_blanks = file.ends_with(".tum");
  const Cells last = cells_of_row(row, by_blanks);
  const std::vector<Cells> rows = rows_above(text.substr(0, begin), by_blanks);
  // The nearest row may be the header; then only the last row itself can be examined.
  if (rows.empty() || (rows.size() == 1 && !by_blanks)) return text;

  std::string why;
  if (last.size() < rows.front().size()) return text;  // which readers refuse, naming the line
  if (row.find('"') == std::string_view::npos) {
    Cells above;
    for (const Cells& cells : rows)
      if (cells.size() >= last.size()) above.push_back(cells[last.size() - 1]);
    why = why_cut(last.back(), above);
  }
  std::string place = file;
  if (text.size() <= kLinesCounted) place += fmt::format(":{}", std::ranges::count(text, '\n') + 1);
  if (why.empty()) {
    warnings.push_back(
        fmt::format("{}: the last row has no newline at its end; it is used, but if the file was cut off "
                    "there, its last number is wrong: copy the file again, or end the row with a newline",
                    place));
    return text;
  }
  warnings.push_back(fmt::format(
      "{}: the last row is cut off: it {}, and has no newline at its end; it is left out: copy the file "
      "again, or delete the row",
      place, why));
  return text.substr(0, begin);
}

}  // namespace octant::io
