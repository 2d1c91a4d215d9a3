// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_log.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/import/decoded_text.h"
#include "io/import/mapping_words.h"
#include "io/run/last_row.h"
#include "io/table/mapping_text.h"
#include "io/table/row_filter.h"
#include "io/table/table_cells.h"
#include "io/table/table_columns.h"
#include "io/table/table_guess.h"
#include "io/table/table_layout.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

/// True for a header with the names of tof.csv.
bool is_own_header(const std::vector<std::string>& names) {
  const auto has = [&names](const char* name) { return std::ranges::count(names, name) == 1; };
  return has("time_s") && has("beacon") && has("tof_s") != has("distance_m");
}

TableMapping with_own_names(const std::vector<std::string>& names, TableMapping mapping) {
  for (const TofColumn& column : kTofColumns)
    if (std::ranges::count(names, column.name) == 1)
      mapping.columns.push_back({std::string(column.name), std::string(column.name)});
  return mapping;
}

class TableReader {
 public:
  TableReader(const std::string& path, const TableMapping& stated) : path_(path), stated_(stated) {
    out_.log.path = path;
    out_.mapping = stated;
  }

  Result<TableLog> read(std::string_view text) {
    auto layout = find_layout(text, path_, stated_);
    if (!layout) return fail(layout.error());
    layout_ = std::move(*layout);
    describe_layout();
    if (auto found = find_columns(); !found) return fail(found.error());
    if (auto rows = read_rows(text); !rows) return fail(rows.error());
    if (auto whole = finish(); !whole) return fail(whole.error());
    return std::move(out_);
  }

 private:
  /// Adds a line about the table. @param option  overrules what was guessed; empty: stated, or certain
  void understood(const std::string& line, const std::string& option = "") {
    out_.understood.push_back(line);
    if (!option.empty()) out_.guessed.push_back(fmt::format("{} (otherwise: {})", line, option));
  }

  void describe_layout() {
    static constexpr std::pair<char, const char*> kDelimiters[] = {
        {',', "commas"}, {';', "semicolons"}, {'\t', "tabulators"}, {'|', "bars"}, {' ', "blanks"}};
    for (const auto& [delimiter, name] : kDelimiters)
      if (layout_.delimiter == delimiter)
        understood(
            fmt::format("cells: separated by {}{}", name,
                        layout_.decimal == DecimalMark::kComma ? ", numbers with decimal commas" : ""));
    if (layout_.header_line > 0) {
      understood(fmt::format("header: line {}", layout_.header_line));
    } else {
      const bool stated = stated_.no_header ||
                          (!stated_.columns.empty() && std::ranges::all_of(stated_.columns, is_numbered));
      understood("header: none, the first line is a row", stated ? "" : "name the columns with --columns");
    }
    if (layout_.lines_before > 0)
      out_.log.warnings.push_back(
          fmt::format("{}: {} lines before the table are left out; the first one is {}", path_,
                      layout_.lines_before, in_quotes(layout_.first_before)));
  }

  Result<void> find_columns() {
    std::vector<std::string> lines;
    own_ = stated_.columns.empty() && is_own_header(layout_.names);
    if (own_) {
      out_.mapping = with_own_names(layout_.names, stated_);
    } else if (stated_.columns.empty()) {
      auto guessed = guess_columns(layout_, path_, stated_, lines);
      if (!guessed) return fail(guessed.error());
      out_.mapping = std::move(*guessed);
      out_.understood.insert(out_.understood.end(), lines.begin(), lines.end());
    }
    const auto columns = columns_of(layout_, path_, out_.mapping,
                                    {.of_tof_csv = own_, .are_guessed = stated_.columns.empty()});
    if (!columns) return fail(columns.error());
    columns_ = *columns;
    keep_formats();
    if (!lines.empty())
      out_.guessed.push_back(
          fmt::format("{} (otherwise: {})", fmt::join(lines, "; "), mapping_to_options(out_.mapping)));
    for (const std::string& name : unused_dates())
      out_.log.warnings.push_back(
          fmt::format("{}: the dates in column {} are not used", path_, in_quotes(name)));
    clock_ = ContinuedClock(columns_.time.clock);
    if (columns_.time_cell)
      understood(
          "times: " + columns_.time.words,
          columns_.time.guessed ? "--time-format s, ms, us, ns, excel, matlab, dw1000, dmy or mdy" : "");
    if (const auto unused = unused_columns(); !unused.empty()) understood("not used: " + listed(unused, 20));
    auto filter = RowFilter::make(layout_, stated_.where, path_);
    if (!filter) return fail(filter.error());
    filter_ = std::move(*filter);
    return {};
  }

  /// Adds the recognised format of times and numbers to the mapping, so that it reads the table alike.
  void keep_formats() {
    if (out_.mapping.time_format.empty()) out_.mapping.time_format = columns_.time.format;
    if (out_.mapping.decimal.empty() && layout_.decimal == DecimalMark::kComma)
      out_.mapping.decimal = "comma";
  }

  Result<void> read_rows(std::string_view text) {
    TableLines lines(text);
    std::string_view line;
    while (lines.next(line)) {
      line_ = lines.number();
      if (line_ < layout_.first_row_line || layout_.first_row_line == 0) continue;
      bool open = false;
      const auto cells = cells_of(line, layout_.delimiter, &open);
      if (open) return fail(open_quote(path_, line_));
      if (!is_whole_row(cells)) {
        leave_out(line);
      } else if (!filter_.accepts(cells, layout_.decimal)) {
        ++filtered_;
      } else if (auto row = read_row(cells); !row) {
        return row;
      }
      ++row_number_;
    }
    return {};
  }

  [[nodiscard]] std::vector<std::string> unused_columns() const {
    std::vector<std::string> unused;
    for (std::size_t i = 0; i < layout_.names.size(); ++i) {
      const bool used =
          i == columns_.clock_cell || std::ranges::count(columns_.all, i, &TableColumn::cell) > 0;
      if (!used && !layout_.names[i].empty()) unused.push_back(layout_.names[i]);
    }
    return unused;
  }

  [[nodiscard]] std::vector<std::string> unused_dates() const {
    std::vector<std::string> dates = unused_columns();
    std::erase_if(dates, [this](const std::string& name) {
      const auto cell = static_cast<std::size_t>(column_named(layout_, name));
      return layout_.rows.empty() || !std::ranges::all_of(layout_.rows, [cell](const auto& row) {
               return cell < row.size() && is_date(row[cell]);
             });
    });
    return dates;
  }

  /// False for a line that is no row: another number of cells than the columns that are read need or the
  /// header has, no number where numbers are expected, or the header again.
  [[nodiscard]] bool is_whole_row(const std::vector<std::string>& cells) const {
    if (layout_.header_line > 0 && cells == layout_.names) return false;
    for (std::size_t i = layout_.names.size(); i < cells.size(); ++i)
      if (!cells[i].empty()) return false;
    bool any_number = false, any_text = false;
    for (const TableColumn& column : columns_.all) {
      const bool may_be_absent = columns_.one_each && column.is_value();
      if (column.cell >= cells.size() && !may_be_absent) return false;
      if (column.target->is_id || column.cell >= cells.size()) continue;
      const bool number =
          is_numeric(column.cell == columns_.time_cell ? columns_.time_text(cells) : cells[column.cell],
                     layout_.decimal);
      (number ? any_number : any_text) = true;
    }
    return any_number || !any_text;
  }
  void leave_out(std::string_view line) {
    if (left_out_++ > 0) return;
    first_left_out_ = line_;
    left_out_text_ = in_quotes(line);
  }

  /// Value of a cell in the unit of its target; NaN if it has no measurement.
  Result<double> value_of(const TableColumn& column, const std::string& cell) {
    double value = std::nan("");
    if (is_no_value(cell) || std::ranges::find(columns_.no_words, cell) != columns_.no_words.end())
      return std::nan("");
    if (cell_number(cell, layout_.decimal, value)) {
      if (!column.is_value() || std::ranges::find(columns_.no_values, value) == columns_.no_values.end())
        return scaled(value, column.unit.factor) + column.unit.offset;
      ++without_value_;
      return std::nan("");
    }
    if (column.target->name == "received_s")
      if (const auto time_s = time_of_text(cell, columns_.time.order)) return *time_s;
    return table_error(path_, line_, fmt::format("{} in column {}", in_quotes(cell), in_quotes(column.name)),
                       "a number", advice_for(cell));
  }
  [[nodiscard]] std::string advice_for(const std::string& cell) const {
    if (cell.find(',') != std::string::npos && layout_.delimiter == ',')
      return "if this is a decimal comma, state it: --decimal comma";
    return fmt::format("if it stands for no measurement: --no-value '{}'", cell);
  }

  /// Time of a row on the continued clock.
  Result<double> time_of(const std::vector<std::string>& cells) {
    if (!columns_.time_cell) return static_cast<double>(row_number_) * *stated_.period_s;
    const std::string cell = columns_.time_text(cells);
    auto value = columns_.time.seconds(cell, layout_.decimal);
    if (double below = 0.0; value && columns_.below_unit_s && *columns_.clock_cell < cells.size() &&
                            cell_number(cells[*columns_.clock_cell], layout_.decimal, below))
      *value += scaled(below, *columns_.below_unit_s);
    if (!value && !is_no_value(cell))
      return table_error(
          path_, line_,
          fmt::format("{} in column {}", in_quotes(cell), in_quotes(layout_.names[*columns_.time_cell])),
          "a number, or a date and time such as 2026-06-11 11:33:48.686", advice_for(cell));
    if (!value || !std::isfinite(*value)) return std::nan("");
    const double stated_s = *value;
    const double time_s = begun_ ? clock_.continued(stated_s, last_time_s_, line_) : stated_s;
    begun_ = true;
    unit_.add(time_s);
    continued_by_s_ = time_s - stated_s;
    return last_time_s_ = time_s;
  }

  /// A row is one arrival, or one for each beacon whose column has a number.
  Result<void> read_row(const std::vector<std::string>& cells) {
    const auto cell = [&](const TableColumn& c) {
      return c.cell < cells.size() ? cells[c.cell] : std::string();
    };
    ImportedArrival row;
    const auto time = time_of(cells);
    if (!time) return fail(time.error());
    if (!std::isfinite(*time)) return ++untimed_, Result<void>();
    row.time_s = *time;
    std::string beacon;
    for (const TableColumn& column : columns_.all) {
      const std::string_view target = column.target->name;
      if (target == "beacon") beacon = name_of(cell(column));
      if (target == "receiver") row.receiver = number_of(name_of(cell(column)));
      if (target == "vehicle") row.vehicle = number_of(name_of(cell(column)));
      if (target == "epoch") row.epoch = epoch_of(cell(column));
      if (target != "amplitude_v" && target != "temperature_degC" && target != "received_s") continue;
      const auto value = value_of(column, cell(column));
      if (!value) return fail(value.error());
      if (target == "amplitude_v") row.amplitude_v = *value;
      if (target == "temperature_degC") row.temperature_degC = *value;
      if (target == "received_s")
        row.received_after_s =
            (column.unit.factor == 1.0 && !columns_.time.format.empty()
                 ? columns_.time.seconds(cell(column), layout_.decimal).value_or(std::nan(""))
                 : seconds_of_stamp(*value)) +
            continued_by_s_ - row.time_s;
    }
    if (!columns_.one_each && beacon.empty()) return ++dropped_, Result<void>();
    for (const TableColumn& column : columns_.all) {
      if (!column.is_value()) continue;
      const std::string& of = columns_.one_each ? column.beacon : beacon;
      if (is_ignored(stated_.ignore, of)) {
        ++out_.log.ignored[of];
        continue;
      }
      const auto value = value_of(column, cell(column));
      if (!value) return fail(value.error());
      if (columns_.one_each && !std::isfinite(*value)) {
        ++out_.log.not_heard;
        continue;
      }
      row.value = *value;
      row.is_distance = column.target->name == "distance_m";
      row.beacon = number_of(of);
      if (!column.receiver.empty()) row.receiver = number_of(column.receiver);
      out_.log.arrivals.push_back(row);
    }
    if (!too_many_names_) return {};
    return table_error(path_, line_, fmt::format("more than {} names", kMostImportedNames),
                       "as many as there may be at a site");
  }

  /// A name as it was before a spreadsheet made a number of it: 7 for 7.0.
  [[nodiscard]] static std::string name_of(const std::string& cell) {
    std::int64_t whole = 0;
    return cell.ends_with(".0") && parse_integer(cell, whole) ? fmt::format("{}", whole)
           : is_no_value(cell) && cell.size() > 1             ? ""
                                                              : cell;
  }
  int number_of(const std::string& name) {
    if (name.empty()) return -1;
    const int number = out_.log.names.number_of(name);
    too_many_names_ = too_many_names_ || number < 0;
    return number;
  }
  /// The number of a stop. Stops with names are numbered in the order of their first rows.
  std::int64_t epoch_of(const std::string& cell) {
    std::int64_t number = 0;
    if (is_no_value(cell)) return kNoEpoch;
    if (parse_integer(cell, number)) return number;
    named_stops_ = true;
    return stops_.number_of(cell);
  }

  Result<void> finish() {
    auto& log = out_.log;
    const std::size_t rows = log.arrivals.size() + log.not_heard + log.ignored_rows() + dropped_ + filtered_;
    if (left_out_ > 0 && left_out_ >= rows)
      return table_error(path_, first_left_out_,
                         fmt::format("a row that does not fit the columns: {}", left_out_text_),
                         fmt::format("{} cells, with numbers as times and values", layout_.names.size()),
                         "if numbers have commas, put them in quotes or separate the cells by semicolons");
    if (rows == 0 && untimed_ > 0)
      return table_error(path_, layout_.first_row_line, "a row without a time",
                         "a number, or a date and time");
    if (rows == 0)
      return table_error(path_, layout_.header_line, "the table has no rows under its header",
                         "a row an arrival");
    const auto warn = [&](std::string text) { log.warnings.push_back(fmt::format("{}{}", path_, text)); };
    if (left_out_ > 0)
      warn(fmt::format(":{}: {} lines are no rows of the table and are left out; the first one is {}",
                       first_left_out_, left_out_, left_out_text_));
    if (filtered_ > 0) warn(fmt::format(": {} rows are left out by the conditions", filtered_));
    if (const auto restarts = clock_.note(path_)) log.warnings.push_back(*restarts);
    if (columns_.time.is_stamp)
      warn(
          ": times beyond 1e11 s are time stamps since 1970 in milliseconds, microseconds or nanoseconds; "
          "they were converted to seconds");
    if (const auto unit = unit_.note(path_); unit && stated_.time_format.empty())
      log.warnings.push_back(*unit);
    if (untimed_ > 0) warn(fmt::format(": {} rows without a time are left out", untimed_));
    if (dropped_ > 0) warn(fmt::format(": {} rows without a beacon were left out", dropped_));
    if (named_stops_) warn(": stops with names are numbered in the order of their first rows");
    if (without_value_ > 0)
      understood(
          fmt::format("no measurement: {} cells with 0, -1 or another number that no distance is close to",
                      without_value_),
          stated_.no_value.empty() ? "--no-value none" : "");
    for (const std::string& note : notes_of_units(columns_, out_.mapping, log.arrivals)) warn(note);
    if (stated_.columns.empty() && !own_) {
      if (std::ranges::none_of(columns_.all, [](const TableColumn& c) { return !c.receiver.empty(); }))
        remove_only_receiver(log);
      remove_only_vehicle(log);
    }
    return {};
  }

  const std::string& path_;
  const TableMapping& stated_;
  TableLog out_;
  TableLayout layout_;
  TableColumns columns_;
  RowFilter filter_;
  ImportedNames stops_;
  ContinuedClock clock_;
  TimeUnitCheck unit_;
  int line_ = 0, first_left_out_ = 0;
  std::size_t row_number_ = 0, left_out_ = 0, filtered_ = 0, untimed_ = 0, dropped_ = 0, without_value_ = 0;
  std::string left_out_text_;
  double last_time_s_ = 0.0, continued_by_s_ = 0.0;
  bool own_ = false, begun_ = false, named_stops_ = false, too_many_names_ = false;
};

}  // namespace

Result<TableLog> read_table_log(const std::string& path, const TableMapping& mapping) {
  const auto text = DecodedText::open(path);
  if (!text) return fail(text.error());
  std::vector<std::string> warnings = text->notes();
  auto table = TableReader(path, mapping).read(without_cut_row(text->text(), path, warnings));
  if (table) table->log.warnings.insert(table->log.warnings.begin(), warnings.begin(), warnings.end());
  return table;
}

}  // namespace octant::io
