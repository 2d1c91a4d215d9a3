// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/time_text.h"

#include <chrono>
#include <cmath>
#include <string>

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
  bool symbol(std::string_view any) {
    if (rest_.empty() || any.find(rest_.front()) == std::string_view::npos) return false;
    rest_.remove_prefix(1);
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
  /// hh:mm:ss, with a fraction behind a point or a comma.
  bool time_of_day(double& seconds) {
    int h = 0, m = 0, s = 0;
    if (!digits(1, 2, h) || !symbol(":") || !digits(2, 2, m) || !symbol(":") || !digits(2, 2, s))
      return false;
    std::string fraction = "0.";
    if (symbol(".,"))
      for (; !rest_.empty() && is_digit(rest_.front()); rest_.remove_prefix(1)) fraction += rest_.front();
    double below = 0.0;
    if (h > 23 || m > 59 || s > 60 || parse_number(fraction + "0", below) != NumberText::kNumber)
      return false;
    seconds = 3600.0 * h + 60.0 * m + s + below;
    return true;
  }
  /// Z, +02:00, +0200 or +02; no text is an offset of zero.
  bool offset(double& seconds) {
    seconds = 0.0;
    if (done() || symbol("Zz")) return done();
    const bool behind = rest_.front() == '-';
    int h = 0, m = 0;
    if (!symbol("+-") || !digits(2, 2, h)) return false;
    if (symbol(":") || !done())
      if (!digits(2, 2, m)) return false;
    seconds = (behind ? -60.0 : 60.0) * (60 * h + m);
    return done() && h < 24 && m < 60;
  }

 private:
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  std::string_view rest_;
};

/// yyyy-mm-dd, yyyy/mm/dd or dd.mm.yyyy as days since 1970-01-01.
bool read_day(TimeScan& scan, double& days) {
  int first = 0, month = 0, last = 0;
  if (!scan.digits(1, 4, first)) return false;
  const bool day_first = scan.symbol(".");
  if (!day_first && !scan.symbol("-/")) return false;
  if (!scan.digits(1, 2, month) || !scan.symbol(day_first ? "." : "-/") || !scan.digits(1, 4, last))
    return false;
  const int year = day_first ? last : first, day = day_first ? first : last;
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok() || year < 1970) return false;
  days = static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
  return true;
}

}  // namespace

std::optional<double> time_of_text(std::string_view text) {
  double value = 0.0;
  if (parse_number(text, value) == NumberText::kNumber)
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  if (TimeScan scan(text); scan.time_of_day(value) && scan.done()) return value;
  TimeScan scan(text);
  double days = 0.0, offset_s = 0.0;
  if (!read_day(scan, days) || !scan.symbol("Tt ") || !scan.time_of_day(value)) return std::nullopt;
  while (scan.symbol(" ")) continue;
  if (!scan.offset(offset_s)) return std::nullopt;
  return kDayOfDates_s * days + value - offset_s;
}

double seconds_of_stamp(double stamp) {
  while (std::isfinite(stamp) && std::abs(stamp) > kLargestStamp_s) stamp /= 1e3;
  return stamp;
}

}  // namespace octant::io
