// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/table_log.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "io/import/column_unit.h"
#include "io/import/mapping_words.h"
#include "io/import/name_pattern.h"
#include "io/import/table_cells.h"
#include "io/run/last_row.h"
#include "io/text/bounds.h"
#include "io/text/open_file.h"
#include "io/text/text.h"
#include "io/text/time_text.h"
#include "io/tof/continued_clock.h"
#include "io/tof/run_parts.h"

namespace octant::io {
namespace {

/// A column of the table that is read.
struct TableColumn {
  std::size_t cell;
  std::string name;  ///< as messages say it
  const TofColumn* target;
  UnitConversion unit;
  std::string beacon, receiver;  ///< names of a column of one beacon
};

/// factor * value. A factor such as 1e-3 divides, so that 50 ms are 0.05 s to the last digit.
double scaled(double value, double factor) {
  const double divisor = std::round(1.0 / factor);
  return std::abs(divisor) >= 2.0 && std::abs(divisor * factor - 1.0) < 1e-15 ? value / divisor
                                                                              : factor * value;
}

struct TableRow {
  double time_s = 0.0;
  std::string text;
};

class TableReader {
 public:
  TableReader(const std::string& path, const TableMapping& mapping) : path_(path), mapping_(mapping) {
    one_column_each_ = std::ranges::any_of(mapping.columns, names_beacon);
  }

  Result<ConvertedTable> read(std::string_view text) {
    while (!text.empty()) {
      const std::string_view line = without_blanks(take_line(text));
      ++line_;
      if (line.empty() || line.front() == '#') continue;
      if (columns_.empty()) {
        const auto is_header = read_first_line(line);
        if (!is_header) return fail(is_header.error());
        if (*is_header) continue;
      }
      if (const auto ok = read_row(line); !ok) return fail(ok.error());
    }
    if (columns_.empty())
      return fail({.code = Errc::kBadInput, .file = path_, .found = "the table is empty"});
    if (rows_.empty() && out_.dropped + out_.ignored + out_.not_heard == 0)
      return error("the table has no rows under its header", "a row an arrival");
    finish();
    return std::move(out_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> error(std::string found, std::string expected,
                                            std::string advice = "") const {
    return fail({.code = Errc::kBadInput,
                 .file = path_,
                 .line = line_,
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .advice = std::move(advice)});
  }

  Result<std::vector<std::string>> cells_in(std::string_view line) const {
    bool open = false;
    auto cells = cells_of(line, out_.delimiter, &open);
    if (!open) return cells;
    return error("a quote that does not end on its line", "quotes in pairs, and a row a line");
  }

  /// Finds the columns. Returns true if the line is a header; a table whose columns are all numbered may be
  /// without.
  Result<bool> read_first_line(std::string_view line) {
    out_.delimiter = delimiter_of(line, mapping_);
    const auto cells = cells_in(line);
    if (!cells) return fail(cells.error());
    const bool headless = is_headless(*cells);
    std::vector<std::string> missing;
    for (const ColumnRule& rule : mapping_.columns) {
      const auto found = find_columns(rule, *cells, headless);
      if (!found) return fail(found.error());
      if (*found == 0) missing.push_back(in_quotes(rule.source));
    }
    const bool numbered = std::ranges::all_of(
        mapping_.columns, [](const ColumnRule& rule) { return numbered_column(rule.source) >= 0; });
    if (headless && !numbered)
      return error("the first line holds numbers only: the table has no header line",
                   "a line with names of columns",
                   "name the columns by their numbers: " + advice_by_number());
    if (missing.empty()) return !headless;
    return error(
        fmt::format("the table has no column {}", listed(missing)),
        fmt::format("columns of its {}: {}", headless ? "first line" : "header", listed(*cells, 20)));
  }

  [[nodiscard]] std::string advice_by_number() const {
    return one_column_each_ ? "--columns time=#1,distance:A1=#2,distance:A2=#3"
                            : "--columns time=#1,beacon=#2,distance=#3";
  }

  /// Adds the columns of a rule and returns how many the table has.
  Result<std::size_t> find_columns(const ColumnRule& rule, const std::vector<std::string>& cells,
                                   bool headless) {
    std::size_t found = 0;
    const int number = numbered_column(rule.source);
    const bool by_name = std::ranges::count(cells, rule.source) > 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      PatternNames names;
      const bool is_it = by_name       ? cells[i] == rule.source && found == 0
                         : number >= 0 ? i == static_cast<std::size_t>(number)
                                       : is_pattern(rule) && matches(rule.source, cells[i], names);
      if (!is_it) continue;
      ++found;
      TableColumn column{i,
                         headless ? rule.source : cells[i],
                         tof_column(rule.target),
                         {},
                         rule.beacon.empty() ? names["beacon"] : rule.beacon,
                         rule.receiver.empty() ? names["receiver"] : rule.receiver};
      if (rule.factor) {
        column.unit.factor = *rule.factor;
      } else if (!column.target->is_id && !headless) {
        const auto unit = unit_of_column(cells[i], rule.target);
        if (!unit) return error(unit.error().found, unit.error().expected, unit.error().advice);
        column.unit = *unit;
      }
      columns_.push_back(std::move(column));
    }
    return found;
  }

  /// A number; 1,5 is one unless commas separate the cells.
  bool number(std::string text, double& value) {
    if (out_.delimiter != ',' && std::ranges::count(text, ',') == 1 && text.find('.') == std::string::npos) {
      std::ranges::replace(text, ',', '.');
      out_.decimal_comma = true;
    }
    return parse_number(text, value) == NumberText::kNumber;
  }

  /// Value of a cell in the unit of its target; NaN if it is empty.
  Result<double> value_of(const TableColumn& column, const std::string& cell) {
    double value = std::nan("");
    if (cell.empty()) return value;
    if (number(cell, value)) return scaled(value, column.unit.factor) + column.unit.offset;
    const bool is_time = column.target->name == "time_s" || column.target->name == "received_s";
    if (is_time)
      if (const auto time_s = time_of_text(cell)) return *time_s;
    return error(fmt::format("{} in column {}", in_quotes(cell), in_quotes(column.name)),
                 is_time ? "a number, or a date and time such as 2026-06-11 11:33:48.686" : "a number",
                 cell.find(',') == std::string::npos || out_.delimiter != ','
                     ? ""
                     : "a decimal comma is read where semicolons or tabulators part the cells");
  }

  /// Time of a row on the continued clock.
  Result<double> time_of(const TableColumn& column, const std::string& cell) {
    const auto value = value_of(column, cell);
    if (!value) return value;
    if (!std::isfinite(*value)) return error("a row without a time", "a number, or a date and time");
    const double stated_s = seconds_of_stamp(*value);
    stamps_ = stamps_ || stated_s != *value;
    const double time_s = begun_ ? clock_.continued(stated_s, last_time_s_, line_) : stated_s;
    begun_ = true;
    unit_.add(time_s);
    continued_by_s_ = time_s - stated_s;
    return last_time_s_ = time_s;
  }

  /// A line is one row, or one for each beacon whose column has a number.
  Result<void> read_row(std::string_view line) {
    const auto cells = cells_in(line);
    if (!cells) return fail(cells.error());
    const auto cell = [&](const TableColumn& c) {
      return c.cell < cells->size() ? (*cells)[c.cell] : std::string();
    };
    for (const TableColumn& column : columns_) {
      if (column.target->name != "beacon") continue;
      if (cell(column).empty()) return ++out_.dropped, Result<void>();
      if (is_ignored(mapping_.ignore, cell(column))) return ++out_.ignored, Result<void>();
    }
    TableRow row;
    std::vector<std::string> fields;
    std::optional<std::size_t> received;
    double received_s = 0.0;
    for (const TableColumn& column : columns_) {
      const bool is_time = column.target->name == "time_s";
      if (column.target->is_id) {
        fields.push_back(csv_field(cell(column)));
        continue;
      }
      const auto value = is_time ? time_of(column, cell(column)) : value_of(column, cell(column));
      if (!value) return fail(value.error());
      if (is_time) row.time_s = *value;
      if (column.target->name == "received_s") {
        received = fields.size();
        received_s = seconds_of_stamp(*value);
      }
      fields.push_back(number_field(*value));
    }
    if (received) fields[*received] = number_field(received_s + continued_by_s_);  // on the clock of time_s
    add_rows(std::move(row), fields);
    return {};
  }

  void add_rows(TableRow row, const std::vector<std::string>& fields) {
    for (std::size_t of = 0; of < columns_.size(); ++of) {
      const TableColumn& column = columns_[of];
      if (one_column_each_ && column.beacon.empty()) continue;
      if (one_column_each_ && is_ignored(mapping_.ignore, column.beacon)) {
        ++out_.ignored;
        continue;
      }
      if (one_column_each_ && fields[of].empty()) {
        ++out_.not_heard;
        continue;
      }
      TableRow arrival{row.time_s, ""};
      for (std::size_t i = 0; i < columns_.size(); ++i)
        if (columns_[i].beacon.empty()) arrival.text += (arrival.text.empty() ? "" : ",") + fields[i];
      if (one_column_each_) arrival.text += "," + csv_field(column.beacon) + "," + fields[of];
      if (has_receivers()) arrival.text += "," + csv_field(column.receiver);
      rows_.push_back(std::move(arrival));
      if (!one_column_each_) return;
    }
  }

  [[nodiscard]] bool has_receivers() const {
    return std::ranges::any_of(columns_, [](const TableColumn& c) { return !c.receiver.empty(); });
  }

  void write_header() {
    std::string value;
    for (const TableColumn& column : columns_) {
      if (!column.beacon.empty()) {
        value = column.target->name;
        continue;
      }
      out_.csv += out_.csv.empty() ? "" : ",";
      out_.csv += column.target->name;
    }
    if (one_column_each_) out_.csv += ",beacon," + value;
    if (has_receivers()) out_.csv += ",receiver";
    out_.csv += '\n';
  }

  void finish() {
    write_header();
    const auto earlier = [](const TableRow& a, const TableRow& b) { return a.time_s < b.time_s; };
    if (const auto restarts = clock_.note(path_)) out_.warnings.push_back(*restarts);
    if (stamps_)
      out_.warnings.push_back(
          path_ +
          ": times beyond 1e11 s are time stamps since 1970 in milliseconds, microseconds or "
          "nanoseconds; they were converted to seconds");
    if (const auto unit = unit_.note(path_)) out_.warnings.push_back(*unit);
    if (!std::ranges::is_sorted(rows_, earlier)) {
      out_.warnings.push_back(path_ + ": the rows are not in the order of time; they were sorted");
      std::ranges::stable_sort(rows_, earlier);
    }
    if (out_.dropped > 0)
      out_.warnings.push_back(fmt::format("{}: {} rows without a beacon were left out", path_, out_.dropped));
    for (const TableRow& row : rows_) out_.csv += row.text + '\n';
    out_.rows = rows_.size();
  }

  const std::string& path_;
  const TableMapping& mapping_;
  int line_ = 0;
  bool one_column_each_ = false;  // a column for each beacon
  std::vector<TableColumn> columns_;
  std::vector<TableRow> rows_;
  ContinuedClock clock_;
  TimeUnitCheck unit_;
  double last_time_s_ = 0.0, continued_by_s_ = 0.0;
  bool begun_ = false, stamps_ = false;
  ConvertedTable out_;
};

}  // namespace

Result<ConvertedTable> convert_table(const std::string& path, const TableMapping& mapping) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  if (auto text = check_lines(map->text(), path); !text) return fail(text.error());
  std::vector<std::string> warnings;
  const std::string_view whole = without_cut_row(map->text(), path, warnings);
  auto table = TableReader(path, mapping).read(without_bom(whole));
  if (table) table->warnings.insert(table->warnings.begin(), warnings.begin(), warnings.end());
  return table;
}

}  // namespace octant::io
