// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_cells.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <utility>

#include "io/import/name_pattern.h"
#include "io/text/text.h"
#include "io/text/time_text.h"

namespace octant::io {
namespace {

constexpr std::string_view kNarrowBlank = "\xE2\x80\xAF", kFixedBlank = "\xC2\xA0";  // no-break spaces

bool is_decimal_digit(char c) { return c >= '0' && c <= '9'; }

bool are_digits(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, is_decimal_digit);
}

/// Removes the separators of thousands from a whole number: groups of three digits after the first one.
bool remove_thousands(std::string& whole, std::string_view separator) {
  const std::size_t sign = whole.starts_with('-') || whole.starts_with('+') ? 1 : 0;
  std::size_t at = whole.find(separator);
  if (at == std::string::npos || at == sign || at > sign + 3 || whole[sign] == '0' ||
      !are_digits(std::string_view(whole).substr(sign, at - sign)))
    return false;
  std::string digits = whole.substr(0, at);
  while (at < whole.size()) {
    const std::string_view group =
        std::string_view(whole).substr(std::min(at + separator.size(), whole.size()), 3);
    if (!std::string_view(whole).substr(at).starts_with(separator) || group.size() < 3 || !are_digits(group))
      return false;
    digits += group;
    at += separator.size() + 3;
  }
  whole = digits;
  return true;
}

bool hexadecimal(std::string_view text, double& value) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return false;
  std::uint64_t whole = 0;
  const auto [stop, status] = std::from_chars(text.data() + 2, text.data() + text.size(), whole, 16);
  value = static_cast<double>(whole);
  return status == std::errc() && stop == text.data() + text.size();
}

/// Position of the decimal mark; npos without one.
std::size_t position_of_mark(std::string_view text, DecimalMark mark) {
  if (mark != DecimalMark::kEither) return text.rfind(mark == DecimalMark::kComma ? ',' : '.');
  const std::size_t last = text.find_last_of(",.");
  const bool alone = last != std::string_view::npos && std::ranges::count(text, text[last]) == 1;
  return alone ? last : std::string_view::npos;
}

}  // namespace

bool cell_number(std::string_view text, DecimalMark mark, double& value) {
  std::string whole(text);
  const bool grouped = mark == DecimalMark::kComma && remove_thousands(whole, ".");
  if (!grouped && parse_number(text, value) == NumberText::kNumber) return true;
  if (hexadecimal(text, value)) return true;
  const std::size_t at = position_of_mark(text, mark);
  whole = text.substr(0, at);
  const std::string_view decimals = at == std::string_view::npos ? "" : text.substr(at + 1);
  if (!decimals.empty() && !is_decimal_digit(decimals.front())) return false;
  for (const std::string_view separator :
       {std::string_view(","), std::string_view("."), std::string_view(" "), std::string_view("'"),
        kFixedBlank, kNarrowBlank})
    if (remove_thousands(whole, separator)) break;
  if (whole.empty() || whole == "-") {
    if (decimals.empty()) return false;
    whole += "0";
  }
  return at != std::string_view::npos && whole.find(',') == std::string::npos
             ? parse_number(whole + "." + std::string(decimals), value) == NumberText::kNumber
             : parse_number(whole, value) == NumberText::kNumber;
}

DecimalMark decimal_mark(const std::vector<std::vector<std::string>>& rows) {
  constexpr std::size_t kGroup = 3;  // digits that may be thousands
  bool comma = false, point = false, unsure_comma = false;
  for (const auto& row : rows)
    for (const std::string& cell : row) {
      double value = 0.0;
      const std::size_t last = cell.find_last_of(",.");
      if (last == std::string::npos || !cell_number(cell, DecimalMark::kEither, value)) continue;
      const bool both = cell.find(',') != std::string::npos && cell.find('.') != std::string::npos;
      std::string whole = cell;
      const bool unsure =
          !both && cell.size() - last - 1 == kGroup && remove_thousands(whole, cell.substr(last, 1));
      const bool repeated = !both && std::ranges::count(cell, cell[last]) > 1;
      const bool is_comma = (cell[last] == ',') != repeated;  // a repeated mark separates thousands
      comma = comma || (is_comma && (!unsure || repeated));
      point = point || (!is_comma && (!unsure || repeated));
      unsure_comma = unsure_comma || (is_comma && unsure);
    }
  if (comma == point) return point || !unsure_comma ? DecimalMark::kEither : DecimalMark::kComma;
  return comma ? DecimalMark::kComma : DecimalMark::kPoint;
}

bool is_no_value(std::string_view cell) {
  static constexpr std::string_view kNoValueWords[] = {
      "",       "-",    "--",      "---",     "?",        "nan",          "-nan",    "nan(ind)", "-nan(ind)",
      "na",     "n/a",  "#n/a",    "#na",     "#nv",      "n.v.",         "k.a.",    "nil",      "null",
      "none",   "inf",  "-inf",    "+inf",    "infinity", "ovf",          "oor",     "fail",     "err",
      "lost",   "void", "timeout", "invalid", "no data",  "out of range", "1.#qnan", "-1.#ind",  "1.#inf",
      "-1.#inf"};
  return cell.size() <= 12 && std::ranges::find(kNoValueWords, lower_case(cell)) != std::end(kNoValueWords);
}

bool is_numeric(std::string_view cell, DecimalMark mark) {
  double value = 0.0;
  return cell_number(cell, mark, value) || is_no_value(cell) || time_of_text(cell, DateOrder::kMonthFirst) ||
         time_of_text(cell, DateOrder::kDayFirst) || is_date(cell);
}

std::pair<std::string_view, std::string_view> date_and_time(std::string_view source) {
  const std::size_t plus = source.find('+');
  if (plus == std::string_view::npos || plus == 0 || plus + 1 == source.size()) return {source, {}};
  return {without_blanks(source.substr(0, plus)), without_blanks(source.substr(plus + 1))};
}

bool is_numbered(const ColumnRule& rule) { return numbered_column(date_and_time(rule.source).first) >= 0; }

bool is_source(const ColumnRule& rule, std::string_view name, std::size_t index) {
  if (name == rule.source) return true;
  PatternNames names;
  if (is_pattern(rule)) return matches(rule.source, name, names);
  const std::string_view source = rule.target == "time_s" ? date_and_time(rule.source).first : rule.source;
  const int number = numbered_column(source);
  return number >= 0 ? index == static_cast<std::size_t>(number) : name == source;
}

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

int numbered_column(std::string_view source) {
  std::int64_t number = 0;
  if (!source.starts_with('#') || !parse_integer(source.substr(1), number) || number < 1 || number > 65536)
    return -1;
  return static_cast<int>(number) - 1;
}

}  // namespace octant::io
