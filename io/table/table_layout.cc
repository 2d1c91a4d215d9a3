// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_layout.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/table/column_unit.h"
#include "io/text/text.h"
#include "io/text/time_text.h"

namespace octant::io {
namespace {

constexpr std::size_t kSampledLines = 1000;
constexpr double kMostCells = 2.0 / 3.0;  // part of the cells of a column by which its kind is recognised

struct Line {
  int number;
  std::vector<std::string> cells;
};

/// The sampled lines, split by one delimiter.
struct Split {
  char delimiter = ',';
  DecimalMark decimal = DecimalMark::kPoint;
  std::vector<Line> lines{};
  std::vector<Line> comments{};  ///< before the first row
  std::size_t columns = 0;       ///< cells of most rows
  std::size_t named = 0;         ///< columns of the mapping on the best line
  double quality = 0.0;
};

/// Cells of a comment as if it were a header: "# t, A1, A2" or "%time,field.range".
std::vector<std::string> cells_of_comment(std::string_view comment, char delimiter) {
  comment = without_blanks(comment.substr(std::min(comment.find_first_not_of("#% \t"), comment.size())));
  // Names above numbers between blanks may have commas between them.
  if (delimiter == ' ' && comment.find(',') != std::string_view::npos) delimiter = ',';
  return cells_of(comment, delimiter);
}

bool is_number_or_time(const std::string& cell, DecimalMark mark) {
  double value = 0.0;
  return cell_number(cell, mark, value) || (!cell.empty() && !is_no_value(cell) && is_numeric(cell, mark));
}

bool is_row(const std::vector<std::string>& cells, DecimalMark mark) {
  return cells.size() >= 2 &&
         std::ranges::any_of(cells, [&](const std::string& cell) { return is_number_or_time(cell, mark); });
}

/// False for a cell that seems to consist of several: it has another delimiter in it, or a blank behind a
/// digit.
bool is_one_cell(const std::string& cell, DecimalMark mark) {
  if (is_numeric(cell, mark)) return true;
  const bool blank_after_number =
      std::isdigit(static_cast<unsigned char>(cell.front())) != 0 && cell.find(' ') != std::string::npos;
  return cell.find_first_of(",;\t|") == std::string::npos && !blank_after_number;
}

std::size_t named_columns(const TableMapping& mapping, const std::vector<std::string>& cells) {
  return static_cast<std::size_t>(std::ranges::count_if(mapping.columns, [&](const ColumnRule& rule) {
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (is_source(rule, cells[i], i)) return true;
    return false;
  }));
}

Split split_lines(const std::vector<std::pair<int, std::string_view>>& lines,
                  const std::vector<std::pair<int, std::string_view>>& comments, char delimiter,
                  const TableMapping& mapping) {
  Split split{.delimiter = delimiter,
              .decimal = delimiter == ',' ? DecimalMark::kPoint : DecimalMark::kEither};
  for (const auto& [number, text] : lines) split.lines.push_back({number, cells_of(text, delimiter)});
  for (const auto& [number, text] : comments)
    split.comments.push_back({number, cells_of_comment(text, delimiter)});
  std::map<std::size_t, std::size_t> counts;
  for (const Line& line : split.lines)
    if (is_row(line.cells, split.decimal)) ++counts[line.cells.size()];
  std::size_t most = 0;
  for (const auto& [cells, count] : counts) {
    if (count < most) continue;
    split.columns = cells;
    most = count;
  }
  for (const auto* some : {&split.lines, &split.comments})
    for (const Line& line : *some) split.named = std::max(split.named, named_columns(mapping, line.cells));
  for (const Line& line : split.lines) {
    if (line.cells.size() != split.columns || !is_row(line.cells, split.decimal)) continue;
    const auto whole =
        std::ranges::count_if(line.cells, [&](const auto& cell) { return is_one_cell(cell, split.decimal); });
    split.quality += static_cast<double>(whole) / static_cast<double>(split.columns * split.lines.size());
  }
  if (split.columns == 0 && !split.lines.empty()) split.columns = split.lines.front().cells.size();
  return split;
}

/// True for columns that have numbers, times or no measurement in most rows.
std::vector<bool> numeric_columns(const Split& split) {
  std::vector<std::size_t> numeric(split.columns), filled(split.columns);
  for (const Line& line : split.lines) {
    if (line.cells.size() != split.columns || !is_row(line.cells, split.decimal)) continue;
    for (std::size_t i = 0; i < split.columns; ++i) {
      if (line.cells[i].empty()) continue;
      ++filled[i];
      numeric[i] += static_cast<std::size_t>(is_numeric(line.cells[i], split.decimal));
    }
  }
  std::vector<bool> all(split.columns);
  for (std::size_t i = 0; i < split.columns; ++i)
    all[i] = filled[i] > 0 && static_cast<double>(numeric[i]) >= kMostCells * static_cast<double>(filled[i]);
  return all;
}

class LayoutFinder {
 public:
  LayoutFinder(const Split& split, const TableMapping& mapping)
      : split_(split), mapping_(mapping), numeric_(numeric_columns(split)) {}

  TableLayout find() {
    layout_.delimiter = split_.delimiter;
    std::size_t first = first_row();
    if (mapping_.no_header) {
      first = 0;
    } else if (const auto named = named_header()) {
      first = use_header(*named) + 1;
    } else if (first > 1 && is_header(split_.lines[first - 2].cells) &&
               are_units(split_.lines[first - 1].cells)) {
      use_header(first - 2);
      add_units(split_.lines[first - 1].cells);
    } else if (first > 0 && is_header(split_.lines[first - 1].cells)) {
      use_header(first - 1);
    } else if (!use_comment_header() && first == split_.lines.size()) {
      first = use_header(0) + 1;
    }
    finish(first);
    return std::move(layout_);
  }

 private:
  [[nodiscard]] std::size_t first_row() const {
    std::size_t i = 0;
    while (i < split_.lines.size() && !is_data(split_.lines[i].cells)) ++i;
    return i;
  }
  [[nodiscard]] bool is_data(const std::vector<std::string>& cells) const {
    if (!is_row(cells, split_.decimal) || cells.size() + 1 < split_.columns ||
        cells.size() > split_.columns + 1)
      return false;
    for (std::size_t i = 0; i < std::min(cells.size(), split_.columns); ++i)
      if (numeric_[i] && !is_numeric(cells[i], split_.decimal)) return false;
    return true;
  }
  /// A line of as many cells as the rows, one less (row names) or with a delimiter at its end, with text
  /// above numbers.
  [[nodiscard]] bool is_header(const std::vector<std::string>& cells) const {
    const std::size_t shift = cells.size() + 1 == split_.columns ? 1 : 0;
    if (cells.size() + shift < split_.columns || cells.size() > split_.columns + 1) return false;
    for (std::size_t i = 0; i < cells.size() && i + shift < split_.columns; ++i)
      if (numeric_[i + shift] && !is_numeric(cells[i], split_.decimal)) return true;
    return false;
  }
  [[nodiscard]] bool are_units(const std::vector<std::string>& cells) const {
    return std::ranges::all_of(cells, [](const std::string& cell) { return cell.empty() || is_unit(cell); });
  }
  /// The first line with all columns that the mapping names; columns by number do not identify it.
  [[nodiscard]] std::optional<std::size_t> named_header() const {
    const bool by_name =
        std::ranges::any_of(mapping_.columns, [](const ColumnRule& rule) { return !is_numbered(rule); });
    if (!by_name) return std::nullopt;
    for (std::size_t i = 0; i < split_.lines.size(); ++i)
      if (named_columns(mapping_, split_.lines[i].cells) == mapping_.columns.size() &&
          !std::ranges::all_of(split_.lines[i].cells,
                               [&](const auto& cell) { return is_numeric(cell, split_.decimal); }))
        return i;
    return std::nullopt;
  }
  std::size_t use_header(std::size_t index) {
    layout_.header_line = split_.lines[index].number;
    layout_.names = split_.lines[index].cells;
    above_ = index + 1;
    return index;
  }
  bool use_comment_header() {
    for (auto comment = split_.comments.rbegin(); comment != split_.comments.rend(); ++comment) {
      if (!split_.lines.empty() && comment->number > split_.lines.front().number) continue;
      const bool named =
          !mapping_.columns.empty() && named_columns(mapping_, comment->cells) == mapping_.columns.size();
      if (!named && (comment->cells.size() != split_.columns || !is_header(comment->cells))) continue;
      layout_.header_line = comment->number;
      layout_.names = comment->cells;
      return true;
    }
    return false;
  }
  void add_units(const std::vector<std::string>& units) {
    for (std::size_t i = 0; i < std::min(units.size(), layout_.names.size()); ++i) {
      if (units[i].empty()) continue;
      const bool bracketed = units[i].find_first_of("[({<") == 0;
      layout_.names[i] += bracketed ? " " + units[i] : fmt::format(" [{}]", units[i]);
    }
  }

  void finish(std::size_t first) {
    std::size_t most_cells = split_.columns;
    for (std::size_t i = first; i < split_.lines.size(); ++i) {
      if (layout_.first_row_line == 0) layout_.first_row_line = split_.lines[i].number;
      if (mapping_.no_header) most_cells = std::max(most_cells, split_.lines[i].cells.size());
      if (is_data(split_.lines[i].cells)) layout_.rows.push_back(split_.lines[i].cells);
    }
    if (layout_.names.empty())
      for (std::size_t i = 0; i < most_cells; ++i) layout_.names.push_back(fmt::format("#{}", i + 1));
    // Tables of R have no name above the names of their rows.
    if (layout_.names.size() + 1 == split_.columns && has_row_names())
      layout_.names.insert(layout_.names.begin(), "");
    const std::size_t before = layout_.header_line > 0 && above_ > 0 ? above_ - 1 : first;
    layout_.lines_before = std::min(before, split_.lines.size());
    if (layout_.lines_before > 0)
      layout_.first_before =
          fmt::format("{}", fmt::join(split_.lines[0].cells, std::string(1, split_.delimiter)));
    layout_.decimal = split_.decimal;
    if (split_.delimiter != ',' || !mapping_.decimal.empty()) layout_.decimal = decimal_mark(layout_.rows);
    if (mapping_.decimal == "comma") layout_.decimal = DecimalMark::kComma;
    if (mapping_.decimal == "point") layout_.decimal = DecimalMark::kPoint;
  }
  /// True if the first cells count the rows.
  [[nodiscard]] bool has_row_names() const {
    double last = 0.0;
    bool counts = !layout_.rows.empty();
    for (std::size_t i = 0; counts && i < layout_.rows.size(); ++i) {
      double value = 0.0;
      if (layout_.rows[i].size() != split_.columns) continue;
      counts = parse_number(layout_.rows[i].front(), value) == NumberText::kNumber &&
               (i == 0 || value == last + 1.0);
      last = value;
    }
    return counts;
  }

  const Split& split_;
  const TableMapping& mapping_;
  std::vector<bool> numeric_;
  std::size_t above_ = 0;  // lines up to the header
  TableLayout layout_;
};

}  // namespace

bool TableLines::next(std::string_view& line, std::vector<std::pair<int, std::string_view>>* comments) {
  constexpr std::string_view kSeparator = "sep=";
  while (!rest_.empty()) {
    line = take_line(rest_);
    // An empty first or last cell between tabulators is kept.
    line = line.substr(0, line.find_last_not_of(" \r") + 1);
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    ++number_;
    if (number_ == 1 && line.starts_with(kSeparator) && line.size() <= kSeparator.size() + 1) {
      delimiter_ = line.size() > kSeparator.size() ? line.back() : '\t';
      continue;
    }
    if (without_blanks(line).empty()) continue;
    if (line.front() != '#' && line.front() != '%') return true;
    if (comments != nullptr) comments->emplace_back(number_, line);
  }
  return false;
}

Error open_quote(const std::string& path, int line) {
  return {.file = path,
          .line = line,
          .found = "a quote that does not end on its line",
          .expected = "quotes in pairs, and a row a line"};
}

Result<TableLayout> find_layout(std::string_view text, const std::string& path, const TableMapping& mapping) {
  TableLines lines(text);
  std::vector<std::pair<int, std::string_view>> sample, comments;
  std::string_view line;
  while (sample.size() < kSampledLines &&
         lines.next(line, comments.size() < kSampledLines ? &comments : nullptr))
    sample.emplace_back(lines.number(), line);
  if (sample.empty()) return fail({.code = Errc::kBadInput, .file = path, .found = "the table is empty"});
  std::optional<Split> best;
  for (const char delimiter : {',', ';', '\t', '|', ' '}) {
    if (lines.stated_delimiter() && delimiter != *lines.stated_delimiter()) continue;
    Split split = split_lines(sample, comments, delimiter, mapping);
    const auto rank = [](const Split& s) {
      return std::tuple(s.named, static_cast<int>(20.0 * s.quality), s.columns);
    };
    if (!best || rank(split) > rank(*best)) best = std::move(split);
  }
  if (!best) best = split_lines(sample, comments, *lines.stated_delimiter(), mapping);
  TableLayout layout = LayoutFinder(*best, mapping).find();
  for (const auto& [number, header] : sample) {
    bool open = false;
    if (number == layout.header_line) (void)cells_of(header, layout.delimiter, &open);
    if (open) return fail(open_quote(path, number));
  }
  return layout;
}

}  // namespace octant::io
