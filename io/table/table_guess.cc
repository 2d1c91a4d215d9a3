// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_guess.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include <fmt/format.h>

#include "io/table/column_words.h"
#include "io/table/mapping_text.h"
#include "io/text/text.h"
#include "io/text/time_text.h"

namespace octant::io {
namespace {

constexpr double kLeastUnixTime = 1e8;  // 1973, in seconds; in other units it is more
constexpr std::size_t kMostBeacons = 256;

/// Content of a column in the first rows.
struct Column {
  std::size_t index = 0;
  NamedColumn meaning{};
  std::size_t filled = 0, numbers = 0, texts = 0, times = 0, dates = 0;
  std::size_t fractions = 0;  ///< numbers that are not whole
  std::size_t decreases = 0;  ///< numbers that are less than the one before
  double largest = 0.0;
  std::set<std::string> different{};

  [[nodiscard]] bool is_number() const { return filled > 0 && texts + times + dates == 0; }
  [[nodiscard]] bool is_time() const { return filled > 0 && times == filled; }
  [[nodiscard]] bool is_date() const { return filled > 0 && dates == filled; }
  [[nodiscard]] bool is_unix_time() const { return is_number() && largest > kLeastUnixTime; }
  /// A few names, most of which return.
  [[nodiscard]] bool may_name_beacons() const {
    const bool counts_rows = numbers == filled && filled > 2 && different.size() == filled && decreases == 0;
    return filled > 0 && !counts_rows && times == 0 && fractions == 0 &&
           different.size() <= std::max<std::size_t>(4, filled / 2) && different.size() <= kMostBeacons;
  }
};

Column column_of(const TableLayout& layout, std::size_t index) {
  Column column{.index = index};
  if (layout.header_line > 0) column.meaning = meaning_of(layout.names[index]);
  double last = -std::numeric_limits<double>::infinity();
  for (const auto& row : layout.rows) {
    if (index >= row.size() || is_no_value(row[index])) continue;
    const std::string& cell = row[index];
    double value = 0.0;
    ++column.filled;
    column.different.insert(cell);
    if (cell_number(cell, layout.decimal, value)) {
      ++column.numbers;
      column.fractions += static_cast<std::size_t>(value != std::floor(value));
      column.decreases += static_cast<std::size_t>(value < last);
      column.largest = std::max(column.largest, value);
      last = value;
    } else if (is_date(cell)) {
      ++column.dates;
    } else if (time_of_text(cell, DateOrder::kDayFirst) || time_of_text(cell, DateOrder::kMonthFirst)) {
      ++column.times;
    } else {
      ++column.texts;
    }
  }
  return column;
}

class ColumnGuess {
 public:
  ColumnGuess(const TableLayout& layout, const std::string& path, const TableMapping& stated,
              std::vector<std::string>& lines)
      : layout_(layout), path_(path), mapping_(stated), lines_(lines) {
    for (std::size_t i = 0; i < layout.names.size(); ++i) columns_.push_back(column_of(layout, i));
  }

  Result<TableMapping> guess() {
    const bool headless = !has_names();
    const bool timed = find_time() || mapping_.period_s.has_value();
    if (!timed) return refuse("the time of each row");
    if (!(headless ? find_values_by_content() : find_values_by_name()))
      return refuse("distances or times of flight");
    if (!headless) {
      add_ids(ColumnRole::kReceiver, "receiver");
      add_ids(ColumnRole::kVehicle, "vehicle");
      add_ids(ColumnRole::kEpoch, "epoch");
    }
    if (auto whole = check_mapping(mapping_); !whole) return refuse("distances or times of flight");
    return std::move(mapping_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> refuse(const char* what) const {
    const bool headless = layout_.header_line == 0;
    return fail(
        {.code = Errc::kBadInput,
         .file = path_,
         .line = headless ? layout_.first_row_line : layout_.header_line,
         .found = fmt::format("no column is recognised as {}", what),
         .expected =
             headless
                 ? fmt::format("a header line, or columns named by their numbers; the table has {} columns",
                               columns_.size())
                 : fmt::format("a table with times and distances; columns of this one: {}",
                               listed(layout_.names, 20)),
         .advice = headless ? "state the columns: --columns time=#1,beacon=#2,distance=#3, or with a column "
                              "for each beacon "
                              "--columns time=#1,distance:A1=#2,distance:A2=#3"
                            : "state the columns: --columns time=COLUMN,beacon=COLUMN,distance=COLUMN, or "
                              "with a column for each "
                              "beacon (r_A1, r_A2) --columns time=COLUMN,distance=r_{beacon}; logs of kits "
                              "are read with "
                              "--format, see octant convert --help"});
  }

  /// False for names that programs give to columns without a name: Var1, Column2, V3, Spalte4.
  [[nodiscard]] bool has_names() const {
    if (layout_.header_line == 0) return false;
    return !std::ranges::all_of(layout_.names, [](const std::string& name) {
      const std::string word = lower_case(name.substr(0, name.find_last_not_of("0123456789 _") + 1));
      return word.size() < name.size() &&
             (word == "var" || word == "column" || word == "col" || word == "v" || word == "x" ||
              word == "field" || word == "spalte" || word == "feld" || word == "c");
    });
  }
  /// The name of a column, or its number where a mapping cannot have the name.
  [[nodiscard]] std::string source_of(const Column& column) const {
    const std::string& name = layout_.names[column.index];
    const bool plain = !name.empty() && name.find_first_of(",=*{}+#:") == std::string::npos &&
                       std::ranges::count(layout_.names, name) == 1;
    return plain ? name : fmt::format("#{}", column.index + 1);
  }
  [[nodiscard]] std::string words_of(const Column& column) const {
    const std::string& name = layout_.names[column.index];
    return layout_.header_line == 0 || name.empty() ? fmt::format("column {}", column.index + 1)
                                                    : "column " + in_quotes(name);
  }
  void add(const char* target, const Column& column) {
    mapping_.columns.push_back({std::string(tof_column(target)->name), source_of(column)});
    used_.insert(column.index);
    lines_.push_back(fmt::format("{}: {}", target, words_of(column)));
  }

  /// Rank of a column as the time of the rows; 0: it is none. Times since 1970 precede dates, whose zone may
  /// not be stated.
  [[nodiscard]] int rank_as_time(const Column& column) const {
    const bool named = column.meaning.role == ColumnRole::kTime ||
                       (column.meaning.role == ColumnRole::kEpoch && column.is_unix_time());
    if (column.is_time()) return named ? 3 : 2;
    if (has_names()) return !named || !column.is_number() ? 0 : column.is_unix_time() ? 4 : 1;
    // Without a header line: a number that grows.
    const bool grows =
        column.is_number() && column.different.size() >= 2 && 10 * column.decreases <= column.filled;
    return !grows ? 0 : column.is_unix_time() ? 4 : 1;
  }

  bool find_time() {
    const Column* best = nullptr;
    for (const Column& column : columns_)
      if (rank_as_time(column) > (best == nullptr ? 0 : rank_as_time(*best))) best = &column;
    if (best == nullptr) return false;
    const auto date = std::ranges::find_if(columns_, &Column::is_date);
    if (best->is_time() && date != columns_.end() && is_time_of_day(*best)) return add_time(*date, *best);
    for (const Column& day : columns_)
      for (const Column& clock : columns_)
        if ((best == &day || best == &clock) && are_compact(day, clock)) return add_time(day, clock);
    const auto below = std::ranges::find_if(columns_, [this](const Column& column) {
      return column.is_number() && is_part_of_second(layout_.names[column.index]);
    });
    if (best->is_number() && best->fractions == 0 && below != columns_.end() && below->index != best->index &&
        is_seconds(layout_.names[best->index]))
      return add_time(*best, *below);
    add("time", *best);
    return true;
  }
  /// Adds a time in two columns.
  bool add_time(const Column& first, const Column& second) {
    mapping_.columns.push_back({"time_s", layout_.names[first.index] + "+" + layout_.names[second.index]});
    used_.insert({first.index, second.index});
    lines_.push_back(fmt::format("time: {} and {}", words_of(first), words_of(second)));
    return true;
  }
  /// True for dates and times of day without separators: 20260611 and 113348.
  [[nodiscard]] bool are_compact(const Column& day, const Column& clock) const {
    if (layout_.header_line == 0 || day.index == clock.index || !day.is_number() || !clock.is_number() ||
        clock.meaning.role != ColumnRole::kTime || layout_.rows.empty())
      return false;
    return std::ranges::all_of(layout_.rows, [&](const auto& row) {
      return day.index < row.size() && clock.index < row.size() && row[day.index].size() == 8 &&
             time_of_text(row[day.index] + " " + row[clock.index]).has_value();
    });
  }
  /// "secs", "field.header.stamp.secs" with "nsecs": the two parts of a time in ROS.
  [[nodiscard]] static bool is_seconds(const std::string& name) {
    return name.ends_with("sec") || name.ends_with("secs") || name.ends_with("seconds");
  }
  [[nodiscard]] static bool is_part_of_second(const std::string& name) {
    return name.ends_with("nsec") || name.ends_with("nsecs") || name.ends_with("nanosec") ||
           name.ends_with("usec");
  }
  [[nodiscard]] static bool is_time_of_day(const Column& column) {
    return std::ranges::none_of(column.different, [](const std::string& cell) {
      return io::is_date(cell.substr(0, cell.find_first_of(" T")));
    });
  }

  [[nodiscard]] std::vector<const Column*> columns_with(ColumnRole role) const {
    std::vector<const Column*> found;
    for (const Column& column : columns_)
      if (column.meaning.role == role && !used_.contains(column.index)) found.push_back(&column);
    return found;
  }
  [[nodiscard]] std::vector<const Column*> values_with(ColumnRole role) const {
    auto found = columns_with(role);
    std::erase_if(found, [](const Column* column) { return column->filled > 0 && !column->is_number(); });
    return found;
  }

  bool find_values_by_name() {
    auto values = values_with(ColumnRole::kTof);
    const char* target = "tof";
    if (values.empty()) {
      target = "distance";
      values = values_with(ColumnRole::kDistance);
    }
    auto beacons = columns_with(ColumnRole::kBeacon);
    std::erase_if(beacons,
                  [](const Column* column) { return column->filled > 0 && !column->may_name_beacons(); });
    // Names that are sure precede "id"; of the two ends of a range, the beacon is the one that changes more.
    std::ranges::stable_sort(beacons, std::greater{}, [](const Column* column) {
      return std::pair(!column->meaning.is_vague,
                       column->meaning.is_end ? column->different.size() : kMostBeacons);
    });
    const bool one_each =
        std::ranges::count_if(values, [](const Column* c) { return !c->meaning.id.empty(); }) > 1;
    if (!beacons.empty() && !values.empty() && !one_each) {
      add("beacon", *beacons.front());
      add(target, *values.front());
      return true;
    }
    const bool has_other_names = std::ranges::any_of(columns_, [&](const Column& column) {
      return !used_.contains(column.index) && column.texts > 0 && column.different.size() > 1 &&
             column.may_name_beacons();
    });
    if (values.size() == 1 && values.front()->meaning.id.empty() && !has_other_names) {
      add(target, *values.front());
      mapping_.columns.back().beacon = "1";
      lines_.back() += ", of one beacon that is named 1";
      return true;
    }
    if (!values.empty()) return add_one_each(target, values);
    return add_one_each("distance", values_with(ColumnRole::kBeaconName));
  }

  /// A column for each beacon.
  bool add_one_each(const char* target, const std::vector<const Column*>& values) {
    std::vector<std::string> beacons, sources;
    for (const Column* column : values) {
      std::string id = column->meaning.id;
      std::ranges::replace(id, ':', '_');
      if (id.empty() || std::ranges::find(beacons, id) != beacons.end()) continue;
      beacons.push_back(id);
      sources.push_back(layout_.names[column->index]);
      used_.insert(column->index);
      mapping_.columns.push_back({std::string(tof_column(target)->name), source_of(*column), {}, id});
    }
    if (beacons.empty()) return false;
    split_tags();
    lines_.push_back(fmt::format("{}: a column for each beacon, {}", target, listed(sources)));
    return true;
  }
  /// "T1_A3" and "Tag1-A3" are receiver T1 and beacon A3.
  void split_tags() {
    const auto place = [](const std::string& id) {
      const std::string lower = lower_case(id);
      std::size_t at = lower.starts_with("tag") ? 3 : lower.starts_with('t') ? 1 : id.size();
      const std::size_t digits = at;
      while (at < id.size() && id[at] >= '0' && id[at] <= '9') ++at;
      return at > digits && at + 1 < id.size() &&
                     std::string_view("_- .").find(id[at]) != std::string_view::npos
                 ? at
                 : 0;
    };
    std::vector<ColumnRule*> wide;
    for (ColumnRule& rule : mapping_.columns)
      if (!rule.beacon.empty()) wide.push_back(&rule);
    if (!std::ranges::all_of(wide, [&](const ColumnRule* rule) { return place(rule->beacon) > 0; })) return;
    for (ColumnRule* rule : wide) {
      const std::size_t at = place(rule->beacon);
      rule->receiver = rule->beacon.substr(0, at);
      rule->beacon.erase(0, at + 1);
    }
  }

  void add_ids(ColumnRole role, const char* target) {
    const auto found = columns_with(role);
    if (found.empty() || found.front()->filled == 0 || found.front()->fractions > 0) return;
    const bool has_receivers =
        std::ranges::any_of(mapping_.columns, [](const ColumnRule& r) { return !r.receiver.empty(); });
    if (!(role == ColumnRole::kReceiver && has_receivers)) add(target, *found.front());
  }

  /// Without names: one column of distances behind a column of names, or several columns of distances.
  bool find_values_by_content() {
    std::vector<const Column*> values, names;
    for (const Column& column : columns_) {
      if (used_.contains(column.index) || column.filled == 0) continue;
      if (column.is_number() && column.fractions > 0) {
        values.push_back(&column);
      } else if (column.may_name_beacons() && column.dates == 0) {
        names.push_back(&column);
      }
    }
    // The beacon is the name that changes most.
    std::ranges::stable_sort(names, {}, [](const Column* c) { return c->different.size(); });
    if (values.size() == 1 && !names.empty()) {
      add("beacon", *names.back());
      names.pop_back();
      add("distance", *values.front());
      if (!names.empty() && names.back()->different.size() > 1) add("receiver", *names.back());
      return true;
    }
    constexpr std::size_t kLeastColumns = 3;  // of distances, without a column of names
    if (values.size() < kLeastColumns || !names.empty()) return false;
    for (std::size_t i = 0; i < values.size(); ++i) {
      used_.insert(values[i]->index);
      mapping_.columns.push_back({"distance_m", source_of(*values[i]), {}, fmt::format("{}", i + 1)});
    }
    lines_.push_back(fmt::format("distance: columns {} to {}, one for each of the beacons 1 to {}",
                                 values.front()->index + 1, values.back()->index + 1, values.size()));
    return true;
  }

  const TableLayout& layout_;
  const std::string& path_;
  TableMapping mapping_;
  std::vector<std::string>& lines_;
  std::vector<Column> columns_;
  std::set<std::size_t> used_;
};

}  // namespace

Result<TableMapping> guess_columns(const TableLayout& layout, const std::string& path,
                                   const TableMapping& stated, std::vector<std::string>& lines) {
  return ColumnGuess(layout, path, stated, lines).guess();
}

}  // namespace octant::io
