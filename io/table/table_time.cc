// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_time.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr double kSerialDay_s = 86400.0;
constexpr double kUnixOfExcel = 25569.0, kUnixOfMatlab = 719529.0;  // serial dates of 1970-01-01
constexpr double kFirstDay = 10957.0, kLastDay = 47482.0;           // 2000 and 2100, in days since 1970
constexpr double kLongestSerialStep = 1e-4;                         // days: 8.6 s; in seconds, 10 kHz
constexpr ClockPeriod kRadioClock{1099511627776.0 / (128 * 499.2e6), "the 40-bit counter of a UWB radio"};
constexpr double kLargestCounter = 1099511627776.0;  // 2^40
constexpr double kUsualStep_s = 0.1;                 // between the measurements of a device

UnitConversion days_since(double unix_day) { return {kSerialDay_s, -kSerialDay_s * unix_day}; }

/// Numbers of a column, as far as they are numbers.
struct Numbers {
  std::vector<double> values;
  double median_step = 0.0;  ///< of the steps that are not zero
  bool whole = true;
  bool all = true;  ///< all cells with content are numbers

  /// True if a number is less than the one before by more than half of a counter's period.
  [[nodiscard]] bool has_restart(double period) const {
    return std::ranges::adjacent_find(values, [&](double a, double b) { return a - b > 0.5 * period; }) !=
           values.end();
  }
  [[nodiscard]] bool within(double least, double most) const {
    return all && !values.empty() &&
           std::ranges::all_of(values, [&](double v) { return v >= least && v <= most; });
  }
};

Numbers numbers_of(const std::vector<std::string>& cells, DecimalMark decimal) {
  Numbers numbers;
  std::vector<double> steps;
  for (const std::string& cell : cells) {
    double value = 0.0;
    if (is_no_value(cell)) continue;
    if (!cell_number(cell, decimal, value) || !std::isfinite(value)) {
      numbers.all = false;
      continue;
    }
    numbers.whole = numbers.whole && value == std::floor(value);
    if (!numbers.values.empty() && value != numbers.values.back())
      steps.push_back(std::abs(value - numbers.values.back()));
    numbers.values.push_back(value);
  }
  if (!steps.empty()) {
    std::ranges::nth_element(steps, steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
    numbers.median_step = steps[steps.size() / 2];
  }
  return numbers;
}

bool all_are_times(const std::vector<std::string>& cells, DateOrder order) {
  return std::ranges::all_of(
      cells, [&](const std::string& cell) { return is_no_value(cell) || time_of_text(cell, order); });
}

void read_dates(const std::vector<std::string>& cells, TimeColumn& column) {
  if (column.order == DateOrder::kNone && !all_are_times(cells, DateOrder::kNone)) {
    const bool month = all_are_times(cells, DateOrder::kMonthFirst),
               day = all_are_times(cells, DateOrder::kDayFirst);
    column.order = day && !month ? DateOrder::kDayFirst : DateOrder::kMonthFirst;
    column.guessed = day && month;
    column.format = column.order == DateOrder::kDayFirst ? "dmy" : "mdy";
  }
  const bool of_day =
      std::ranges::all_of(cells,
                          [](const std::string& cell) {
                            return is_no_value(cell) || cell.find_first_of("-/") == std::string::npos;
                          }) &&
      std::ranges::none_of(cells, [](const std::string& cell) {
        const std::string day = cell.substr(0, cell.find_first_of(" T"));
        const bool compact = day.size() == 8 && day.find_first_not_of("0123456789") == std::string::npos;
        return compact || is_date(day);
      });
  if (of_day) {
    column.clock = ClockPeriod{kSerialDay_s, "the time of day"};
    column.words = "times of day";
    return;
  }
  const bool zoned = std::ranges::any_of(cells, [](const std::string& cell) {
    const std::size_t minus = cell.rfind('-'), colon = cell.find(':');
    return !cell.empty() &&
           (cell.back() == 'Z' || cell.ends_with("UTC") || cell.find('+') != std::string::npos ||
            (minus != std::string::npos && colon != std::string::npos && minus > colon));
  });
  column.words = "dates and times";
  if (column.order == DateOrder::kDayFirst) column.words += ", the day first";
  if (column.order == DateOrder::kMonthFirst) column.words += ", the month first";
  if (!zoned) column.words += ", without a zone: used as UTC";
}

struct TimeUnit {
  const char *format, *words;
  double factor;
};
constexpr TimeUnit kTimeUnits[] = {{"s", "seconds", 1.0},
                                   {"ms", "milliseconds", 1e-3},
                                   {"us", "microseconds", 1e-6},
                                   {"ns", "nanoseconds", 1e-9}};

void use_unit(const TimeUnit& unit, TimeColumn& column) {
  column.unit.factor = unit.factor;
  column.format = unit.format;
  column.words = unit.words;
}

/// Seconds, milliseconds, microseconds or nanoseconds: the steps of a device are nearest to 0.1 s.
void guess_unit(const Numbers& numbers, TimeColumn& column) {
  if (!numbers.whole || numbers.median_step <= 0.0) return;
  const double decades = std::log10(numbers.median_step / kUsualStep_s);
  const auto unit = static_cast<std::size_t>(std::clamp(std::round(decades / 3.0), 0.0, 3.0));
  if (unit == 0) return;
  use_unit(kTimeUnits[unit], column);
  column.guessed = true;
}

/// Time stamps since 1970 that are dates of 2000 to 2100 in milliseconds, microseconds or nanoseconds.
bool is_stamp(const Numbers& numbers, TimeColumn& column) {
  for (const TimeUnit& unit : kTimeUnits) {
    const double scale = kSerialDay_s / unit.factor;
    if (unit.factor == 1.0 || !numbers.within(kFirstDay * scale, kLastDay * scale)) continue;
    use_unit(unit, column);
    column.is_stamp = true;
    return true;
  }
  return false;
}

void stated_format(std::string_view stated, TimeColumn& column) {
  column.words = stated;
  for (const TimeUnit& unit : kTimeUnits)
    if (stated == unit.format) column.unit.factor = unit.factor;
  if (stated == "excel") column.unit = days_since(kUnixOfExcel);
  if (stated == "matlab") column.unit = days_since(kUnixOfMatlab);
  if (stated == "dmy") column.order = DateOrder::kDayFirst;
  if (stated == "mdy") column.order = DateOrder::kMonthFirst;
  if (stated != "dw1000") return;
  column.unit.factor = kRadioClock.period_s / kLargestCounter;
  column.clock = kRadioClock;
}

bool has_word(std::string_view name, const char* word) {
  return lower_case(name).find(word) != std::string::npos;
}

bool is_radio_counter(std::string_view name, const std::vector<std::string>& cells, const Numbers& numbers) {
  const bool hexadecimal = !cells.empty() && lower_case(cells.front()).starts_with("0x");
  return numbers.whole && numbers.within(0.0, kLargestCounter) &&
         (has_word(name, "tick") || has_word(name, "dw1000") || hexadecimal ||
          numbers.has_restart(kLargestCounter));
}

bool guess_serial_dates(std::string_view name, const Numbers& numbers, TimeColumn& column) {
  const bool dated = has_word(name, "date") || has_word(name, "datum") || has_word(name, "excel");
  const bool excel = numbers.within(kUnixOfExcel + kFirstDay, kUnixOfExcel + kLastDay);
  const bool matlab = numbers.within(kUnixOfMatlab + kFirstDay, kUnixOfMatlab + kLastDay);
  if (!numbers.whole && numbers.median_step > 0.0 && numbers.median_step < kLongestSerialStep &&
      numbers.within(0.0, 1.0)) {
    column.unit.factor = kSerialDay_s;
    column.clock = ClockPeriod{kSerialDay_s, "the time of day"};
    column.words = "times of day as parts of a day";
    column.guessed = true;
    return true;
  }
  if (numbers.whole || !(dated || numbers.median_step < kLongestSerialStep) || !(excel || matlab))
    return false;
  column.unit = days_since(excel ? kUnixOfExcel : kUnixOfMatlab);
  column.format = excel ? "excel" : "matlab";
  column.words = excel ? "serial dates of Excel, used as UTC" : "serial dates of MATLAB, used as UTC";
  column.guessed = true;
  return true;
}

std::string words_of_factor(double factor) {
  static constexpr std::pair<double, const char*> kUnitNames[] = {{1.0, "seconds"},
                                                                  {1e-3, "milliseconds"},
                                                                  {1e-6, "microseconds"},
                                                                  {1e-9, "nanoseconds"},
                                                                  {60.0, "minutes"}};
  for (const auto& [value, name] : kUnitNames)
    if (value == factor) return name;
  return fmt::format("counts of {} s", exact(factor));
}

}  // namespace

double scaled(double value, double factor) {
  const double divisor = std::round(1.0 / factor);
  return std::abs(divisor) >= 2.0 && std::abs(divisor * factor - 1.0) < 1e-15 ? value / divisor
                                                                              : factor * value;
}

std::optional<double> TimeColumn::seconds(std::string_view cell, DecimalMark decimal) const {
  double value = 0.0;
  if (cell_number(cell, decimal, value)) {
    if (unit.factor != kSerialDay_s) return scaled(value, unit.factor);
    constexpr double kDigits = 1e5;  // ten decimals of a day are 9 us
    return std::round((unit.factor * value + unit.offset) * kDigits) / kDigits;
  }
  return time_of_text(cell, order);
}

Result<TimeColumn> time_column(std::string_view name, const std::vector<std::string>& cells,
                               DecimalMark decimal, std::string_view stated, std::optional<double> factor,
                               bool guess) {
  TimeColumn column;
  column.words = "seconds";
  const Numbers numbers = numbers_of(cells, decimal);
  if (factor) {
    column.unit.factor = *factor;
    column.words = fmt::format("a number times {}", exact(*factor));
    return column;
  }
  if (!stated.empty()) stated_format(stated, column);
  if (!numbers.all) {
    read_dates(cells, column);
    return column;
  }
  if (!stated.empty()) return column;
  if (is_radio_counter(name, cells, numbers)) {
    stated_format("dw1000", column);
    column.format = "dw1000";
    column.words = "40-bit counts of a UWB radio";
    column.guessed = true;
    return column;
  }
  const auto unit = unit_of_column(name, "time_s");
  if (!unit) return fail(unit.error());
  column.unit = *unit;
  if (unit->factor == 1.0 && is_stamp(numbers, column)) return column;
  if (without_unit(name) != name || unit->factor != 1.0) {
    if (unit->factor == kRadioClock.period_s / kLargestCounter) column.clock = kRadioClock;
    column.words = words_of_factor(unit->factor);
  } else if (!guess_serial_dates(name, numbers, column) &&
             (guess || !numbers.within(0.0, kSerialDay_s * kLastDay))) {
    guess_unit(numbers, column);
  }
  return column;
}

}  // namespace octant::io
