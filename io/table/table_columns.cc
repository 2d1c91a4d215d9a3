// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "io/import/name_pattern.h"
#include "io/table/row_filter.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

class ColumnFinder {
 public:
  ColumnFinder(const TableLayout& layout, const std::string& path, const TableMapping& mapping,
               ColumnSource source)
      : layout_(layout), path_(path), mapping_(mapping), source_(source) {}

  Result<TableColumns> find() {
    out_.one_each = std::ranges::any_of(mapping_.columns, names_beacon);
    if (auto named = check_sources(); !named) return fail(named.error());
    for (const ColumnRule& rule : mapping_.columns)
      if (auto found = add_columns(rule); !found) return fail(found.error());
    if (auto time = find_time(); !time) return fail(time.error());
    find_no_values();
    return std::move(out_);
  }

 private:
  Result<void> check_sources() const {
    std::vector<std::string> missing;
    for (const ColumnRule& rule : mapping_.columns) {
      bool found = false;
      for (std::size_t i = 0; i < layout_.names.size() && !found; ++i)
        found = is_source(rule, layout_.names[i], i);
      const std::string_view second =
          rule.target == "time_s" && found ? date_and_time(rule.source).second : "";
      if (!second.empty() && column_named(layout_, rule.source) < 0)
        found = column_named(layout_, second) >= 0;
      if (!found) missing.push_back(in_quotes(rule.source));
    }
    if (missing.empty()) return {};
    if (layout_.header_line > 0)
      return table_error(path_, layout_.header_line,
                         fmt::format("the table has no column {}", listed(missing)),
                         fmt::format("columns of its header: {}", listed(layout_.names, 20)));
    const bool numbered = std::ranges::all_of(mapping_.columns, is_numbered);
    if (numbered)
      return table_error(path_, layout_.first_row_line,
                         fmt::format("the table has no column {}", listed(missing)),
                         fmt::format("numbers of its {} columns", layout_.names.size()));
    return table_error(path_, layout_.first_row_line,
                       "the first line holds numbers only: the table has no header line",
                       "a line with names of columns",
                       fmt::format("name the columns by their numbers: --columns {}",
                                   out_.one_each ? "time=#1,distance:A1=#2,distance:A2=#3"
                                                 : "time=#1,beacon=#2,distance=#3"));
  }

  Result<void> add_columns(const ColumnRule& rule) {
    const bool by_name = std::ranges::count(layout_.names, rule.source) > 0;
    for (std::size_t i = 0; i < layout_.names.size(); ++i) {
      const std::string& name = layout_.names[i];
      if (by_name ? name != rule.source : !is_source(rule, name, i)) continue;
      PatternNames names;
      if (is_pattern(rule)) (void)matches(rule.source, name, names);
      TableColumn column{i,
                         layout_.header_line > 0 ? name : rule.source,
                         tof_column(rule.target),
                         {},
                         rule.beacon.empty() ? names["beacon"] : rule.beacon,
                         rule.receiver.empty() ? names["receiver"] : rule.receiver};
      if (rule.factor) {
        column.unit.factor = *rule.factor;
      } else if (!column.target->is_id && rule.target != "time_s" && layout_.header_line > 0) {
        const auto unit = unit_of_column(name, rule.target);
        if (!unit)
          return table_error(path_, layout_.header_line, unit.error().found, unit.error().expected,
                             unit.error().advice);
        column.unit = *unit;
      }
      if (rule.target == "time_s") {
        out_.time_cell = i;
        const std::string_view second = date_and_time(rule.source).second;
        if (!by_name && !second.empty())
          find_second_time(static_cast<std::size_t>(column_named(layout_, second)));
      }
      out_.all.push_back(std::move(column));
      if (by_name || !is_pattern(rule)) break;
    }
    return {};
  }

  /// The second column of a time: a time of day, or a number such as nanoseconds.
  void find_second_time(std::size_t cell) {
    out_.clock_cell = cell;
    const bool numbers = std::ranges::all_of(layout_.rows, [&](const auto& row) {
      double value = 0.0;
      return cell >= row.size() || cell_number(row[cell], layout_.decimal, value);
    });
    const bool compact = std::ranges::all_of(layout_.rows, [&](const auto& row) {  // 20260611 and 113348
      return cell < row.size() && *out_.time_cell < row.size() &&
             time_of_text(row[*out_.time_cell] + " " + row[cell]);
    });
    const auto unit = unit_of_column(layout_.names[cell], "time_s");
    if (numbers && !compact && unit) out_.below_unit_s = unit->factor;
  }

  Result<void> find_time() {
    if (!out_.time_cell) {
      if (mapping_.period_s) return {};
      return table_error(path_, layout_.header_line, "no column is named as the time",
                         "time=COLUMN in --columns",
                         "for lines at equal intervals, state the interval: --period-s 0.1");
    }
    std::vector<std::string> cells;
    for (const auto& row : layout_.rows)
      if (row.size() == layout_.names.size() && is_numeric(out_.time_text(row), layout_.decimal))
        cells.push_back(out_.time_text(row));
    const auto rule = std::ranges::find(mapping_.columns, "time_s", &ColumnRule::target);
    const bool has_stops = std::ranges::count(mapping_.columns, "epoch", &ColumnRule::target) > 0;
    auto time =
        time_column(layout_.header_line > 0 ? layout_.names[*out_.time_cell] : "", cells, layout_.decimal,
                    mapping_.time_format, rule->factor, source_.are_guessed && !has_stops);
    if (!time)
      return table_error(path_, layout_.header_line, time.error().found, time.error().expected,
                         time.error().advice);
    out_.time = std::move(*time);
    return {};
  }

  /// Numbers that stand for no measurement: as stated, or 0, -1 and other numbers that no distance is close
  /// to.
  void find_no_values() {
    static constexpr double kUsual[] = {0.0, -1.0, -9.0, -99.0, -999.0, -9999.0};
    static constexpr double kLargeNumbers[] = {999.0,      9999.0,       99999.0,     999999.0,
                                               8190.0,     8191.0,       65534.0,     65535.0,
                                               16777215.0, 2147483647.0, 4294967295.0};
    constexpr double kAbove = 3.0;  // times the largest measurement
    if (mapping_.no_value.size() == 1 && mapping_.no_value.front() == "none") return;
    for (const std::string& word : mapping_.no_value) {
      double value = 0.0;
      if (cell_number(word, layout_.decimal, value)) {
        out_.no_values.push_back(value);
      } else {
        out_.no_words.push_back(word);
      }
    }
    if (!mapping_.no_value.empty() || source_.of_tof_csv) return;
    out_.no_values.assign(std::begin(kUsual), std::end(kUsual));
    double largest = 0.0;
    for (const auto& row : layout_.rows)
      for (const TableColumn& column : out_.all) {
        double value = 0.0;
        if (!column.is_value() || column.cell >= row.size() ||
            !cell_number(row[column.cell], layout_.decimal, value))
          continue;
        if (std::ranges::find(kLargeNumbers, value) == std::end(kLargeNumbers) && std::isfinite(value))
          largest = std::max(largest, value);
      }
    for (const double value : kLargeNumbers)
      if (value > kAbove * largest) out_.no_values.push_back(value);
  }

  const TableLayout& layout_;
  const std::string& path_;
  const TableMapping& mapping_;
  ColumnSource source_;
  TableColumns out_;
};

}  // namespace

std::string TableColumns::time_text(const std::vector<std::string>& cells) const {
  std::string text = *time_cell < cells.size() ? cells[*time_cell] : "";
  if (clock_cell && !below_unit_s && *clock_cell < cells.size()) text += " " + cells[*clock_cell];
  return text;
}

std::vector<std::string> notes_of_units(const TableColumns& columns, const TableMapping& mapping,
                                        const std::vector<ImportedArrival>& arrivals) {
  constexpr double kFar_m = 200.0, kLong_s = 1.0;  // beyond the reach of radio and ultrasound indoors
  std::vector<std::string> notes;
  bool is_stated = false;
  for (const TableColumn& column : columns.all) {
    const bool has_format = column.target->name == "time_s" && !mapping.time_format.empty();
    const bool has_factor = has_format || std::ranges::any_of(mapping.columns, [&](const ColumnRule& rule) {
                              return rule.target == column.target->name && rule.factor.has_value();
                            });
    if (column.is_value()) is_stated = is_stated || has_factor || without_unit(column.name) != column.name;
    const double factor = factor_of_doubtful_unit(column.name, column.target->name);
    if (factor != 1.0 && !has_factor)
      notes.push_back(
          fmt::format(": column {} is used without a unit; if its name states one, add the "
                      "factor: --columns {}={}*{}",
                      in_quotes(column.name), column.target->short_name, column.name, exact(factor)));
  }
  std::vector<double> values;
  for (const ImportedArrival& a : arrivals)
    if (std::isfinite(a.value)) values.push_back(a.value);
  if (values.empty()) return notes;
  const bool distances = arrivals.front().is_distance;
  const bool whole = distances && std::ranges::all_of(values, [](double v) { return v == std::floor(v); });
  std::ranges::sort(values);
  const double median = values[values.size() / 2];
  if (whole && values.back() >= kFar_m) {
    notes.push_back(
        fmt::format(": the distances are whole numbers up to {}, used as metres; if they are millimetres, "
                    "state it as in --columns distance=COLUMN*1e-3",
                    exact(values.back())));
  } else if (!is_stated && median > (distances ? kFar_m : kLong_s)) {
    notes.push_back(fmt::format(
        ": the median of the {} is {}, used as {}; if they have another unit, state "
        "it as in --columns {}",
        distances ? "distances" : "times of flight", exact(median), distances ? "metres" : "seconds",
        distances ? "distance=COLUMN*1e-3" : "tof=COLUMN*1e-9"));
  }
  return notes;
}

Result<TableColumns> columns_of(const TableLayout& layout, const std::string& path,
                                const TableMapping& mapping, ColumnSource source) {
  return ColumnFinder(layout, path, mapping, source).find();
}

}  // namespace octant::io
