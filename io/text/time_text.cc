// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/time_text.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr double kDayOfDates_s = 86400.0;
constexpr double kLargestStamp_s = 1e11;

/// Takes the parts of a time off the front of a text.
class TimeScan {
 public:
  explicit TimeScan(std::string_view text) : rest_(text) {}

  [[nodiscard]] bool done() const { return rest_.empty(); }
  [[nodiscard]] bool has_digits(std::size_t count) const {
    return rest_.size() >= count &&
           std::all_of(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(count), is_digit);
  }
  bool symbol(std::string_view any) {
    if (rest_.empty() || any.find(rest_.front()) == std::string_view::npos) return false;
    rest_.remove_prefix(1);
    return true;
  }
  /// One of the words, in any case.
  bool word(std::string_view text) {
    if (lower_case(rest_.substr(0, text.size())) != text) return false;
    rest_.remove_prefix(text.size());
    return true;
  }
  /// A whole number of `least` to `most` digits.
  bool digits(std::size_t least, std::size_t most, int& value) {
    std::size_t n = 0;
    value = 0;
    for (; n < most && n < rest_.size() && is_digit(rest_[n]); ++n) value = 10 * value + (rest_[n] - '0');
    rest_.remove_prefix(n);
    return n >= least;
  }
  /// hh:mm:ss, with a fraction behind a point or a comma, and with AM or PM. hh:mm if the seconds may be
  /// absent.
  bool time_of_day(double& seconds, bool with_seconds) {
    int h = 0, m = 0, s = 0;
    double below = 0.0;
    const bool compact = !with_seconds && has_digits(6);
    if (!digits(compact ? 2 : 1, 2, h) || !(compact || symbol(":")) || !digits(2, 2, m)) return false;
    if (compact || symbol(":")) {
      if (!digits(2, 2, s) || !fraction(below)) return false;
    } else if (with_seconds) {
      return false;
    }
    if (!half_day(h) || h > 23 || m > 59 || s > 60) return false;
    seconds = 3600.0 * h + 60.0 * m + s + below;
    return true;
  }
  /// Z, UTC, +02:00, +0200 or +02, with the name of the zone in brackets; no text is an offset of zero.
  bool offset(double& seconds) {
    seconds = 0.0;
    if (const auto zone = rest_.find('['); zone != std::string_view::npos && rest_.ends_with(']'))
      rest_ = rest_.substr(0, zone);
    if (done() || word("utc") || word("gmt") || symbol("Zz")) return done();
    const bool behind = rest_.front() == '-';
    int h = 0, m = 0;
    if (!symbol("+-") || !digits(2, 2, h)) return false;
    if (symbol(":") || !done())
      if (!digits(2, 2, m)) return false;
    seconds = (behind ? -60.0 : 60.0) * (60 * h + m);
    return done() && h < 24 && m < 60;
  }
  /// The number of a month by the first letters of its English or German name.
  bool month_name(int& month) {
    static constexpr std::array<std::string_view, 16> kMonthNames = {"jan", "feb", "mar", "apr", "may", "jun",
                                                                     "jul", "aug", "sep", "oct", "nov", "dec",
                                                                     "mrz", "mai", "okt", "dez"};
    static constexpr std::array<int, 4> kGerman = {3, 5, 10, 12};
    for (std::size_t i = 0; i < kMonthNames.size(); ++i) {
      if (!word(kMonthNames[i])) continue;
      month = i < 12 ? static_cast<int>(i) + 1 : kGerman[i - 12];
      return true;
    }
    return false;
  }

 private:
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  bool fraction(double& below) {
    std::string text = "0.";
    if (symbol(".,:"))
      for (; !rest_.empty() && is_digit(rest_.front()); rest_.remove_prefix(1)) text += rest_.front();
    return parse_number(text + "0", below) == NumberText::kNumber;
  }
  /// Adds the half day of "PM" to an hour.
  bool half_day(int& hour) {
    const std::string_view before = rest_;
    while (symbol(" ")) continue;
    const bool afternoon = word("pm");
    if (!afternoon && !word("am")) {
      rest_ = before;
      return true;
    }
    if (hour < 1 || hour > 12) return false;
    hour = hour % 12 + (afternoon ? 12 : 0);
    return true;
  }
  std::string_view rest_;
};

/// A day as three numbers in the order of the text.
struct DayParts {
  int first = 0, second = 0, third = 0;
  char separator = ' ';
  bool has_month_name = false;
};

bool read_day_parts(TimeScan& scan, DayParts& day) {
  if (scan.has_digits(8)) {
    day.separator = '-';
    return scan.digits(4, 4, day.first) && scan.digits(2, 2, day.second) && scan.digits(2, 2, day.third);
  }
  if (!scan.digits(1, 4, day.first)) return false;
  for (const char symbol : {'.', '-', '/'})
    if (day.separator == ' ' && scan.symbol(std::string_view(&symbol, 1))) day.separator = symbol;
  if (day.separator == ' ') return false;
  day.has_month_name = scan.month_name(day.second);
  return (day.has_month_name || scan.digits(1, 2, day.second)) &&
         scan.symbol(std::string_view(&day.separator, 1)) && scan.digits(1, 4, day.third);
}

/// yyyy-mm-dd, yyyy/mm/dd, yyyymmdd, dd.mm.yyyy, dd-Jun-yyyy, or with slashes in the order that is stated, as
/// days since 1970-01-01.
bool read_day(TimeScan& scan, DateOrder order, double& days) {
  constexpr int kLargestMonth = 12, kLargestDay = 31;
  DayParts parts;
  if (!read_day_parts(scan, parts)) return false;
  int year = parts.first, month = parts.second, day = parts.third;
  const bool year_last = parts.separator == '.' || parts.has_month_name ||
                         (parts.separator == '/' && parts.first <= kLargestDay && order != DateOrder::kNone);
  if (year_last) {
    std::swap(year, day);
    if (parts.separator == '/' && order == DateOrder::kMonthFirst) std::swap(month, day);
    if (year < 100) year += 2000;
  }
  if (month > kLargestMonth) return false;
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok() || year < 1970) return false;
  days = static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
  return true;
}

}  // namespace

std::optional<double> time_of_text(std::string_view text, DateOrder order) {
  double value = 0.0;
  if (parse_number(text, value) == NumberText::kNumber)
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  if (TimeScan scan(text); scan.time_of_day(value, true) && scan.done()) return value;
  TimeScan scan(text);
  double days = 0.0, offset_s = 0.0;
  if (!read_day(scan, order, days) || !scan.symbol("Tt ,")) return std::nullopt;
  while (scan.symbol(" ")) continue;
  if (!scan.time_of_day(value, false)) return std::nullopt;
  while (scan.symbol(" ")) continue;
  if (!scan.offset(offset_s)) return std::nullopt;
  return kDayOfDates_s * days + value - offset_s;
}

bool is_date(std::string_view text) {
  double number = 0.0;
  if (parse_number(text, number) == NumberText::kNumber) return false;
  return std::ranges::any_of(std::array{DateOrder::kMonthFirst, DateOrder::kDayFirst},
                             [text](DateOrder order) {
                               double days = 0.0;
                               TimeScan scan(text);
                               return read_day(scan, order, days) && scan.done();
                             });
}

double seconds_of_stamp(double stamp) {
  while (std::isfinite(stamp) && std::abs(stamp) > kLargestStamp_s) stamp /= 1e3;
  return stamp;
}

}  // namespace octant::io
