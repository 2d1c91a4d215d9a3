// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/table_cells.h"

#include <algorithm>
#include <utility>

#include "io/import/name_pattern.h"
#include "io/text/text.h"
#include "io/text/time_text.h"

namespace octant::io {
namespace {

bool is_there(const ColumnRule& rule, const std::vector<std::string>& cells) {
  if (const int number = numbered_column(rule.source); number >= 0)
    return static_cast<std::size_t>(number) < cells.size();
  PatternNames names;
  return std::ranges::any_of(cells, [&](const std::string& cell) {
    return cell == rule.source || (is_pattern(rule) && matches(rule.source, cell, names));
  });
}

}  // namespace

const TofColumn* tof_column(std::string_view name) {
  for (const TofColumn& c : kTofColumns)
    if (name == c.name || name == c.short_name) return &c;
  return nullptr;
}

std::vector<std::string> cells_of(std::string_view line, char delimiter, bool* open) {
  std::vector<std::string> cells;
  std::string cell;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted) {
      if (c != '"') {
        cell += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        cell += line[++i];
      } else {
        quoted = false;
      }
    } else if (c == '"' && without_blanks(cell).empty()) {
      quoted = true;
      cell.clear();
    } else if (c == delimiter) {
      if (delimiter != ' ' || !cell.empty()) cells.push_back(std::exchange(cell, {}));
    } else {
      cell += c;
    }
  }
  if (delimiter != ' ' || !cell.empty()) cells.push_back(cell);
  if (open != nullptr) *open = quoted;
  for (std::string& text : cells) text = without_blanks(text);
  return cells;
}

char delimiter_of(std::string_view header, const TableMapping& mapping) {
  char best = ',';
  std::size_t most_found = 0, most_cells = 0;
  for (const char delimiter : {',', ';', '\t', '|', ' '}) {
    const auto cells = cells_of(header, delimiter);
    const auto found = static_cast<std::size_t>(std::ranges::count_if(
        mapping.columns, [&](const ColumnRule& rule) { return is_there(rule, cells); }));
    if (std::pair(found, cells.size()) <= std::pair(most_found, most_cells)) continue;
    best = delimiter;
    most_found = found;
    most_cells = cells.size();
  }
  return best;
}

int numbered_column(std::string_view source) {
  std::int64_t number = 0;
  if (!source.starts_with('#') || !parse_integer(source.substr(1), number) || number < 1 || number > 65536)
    return -1;
  return static_cast<int>(number) - 1;
}

bool is_headless(const std::vector<std::string>& cells) {
  double value = 0.0;
  bool any = false;
  for (const std::string& cell : cells) {
    const NumberText kind = parse_number(cell, value);
    if (kind == NumberText::kNotNumber && !time_of_text(cell)) return false;
    any = any || kind != NumberText::kEmpty;
  }
  return any;
}

}  // namespace octant::io
