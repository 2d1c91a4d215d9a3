// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/utc_time.h"

#include <array>
#include <chrono>
#include <cstdio>

namespace octant {
namespace {

constexpr std::int64_t kSecondsADay = 86400;

/// Scanner over the text; the first mismatch makes it fail permanently.
class DateScanner {
 public:
  explicit DateScanner(std::string_view text) : text_(text) {}

  int digits(std::size_t count) {
    int value = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (at_ >= text_.size() || text_[at_] < '0' || text_[at_] > '9') {
        failed_ = true;
        return 0;
      }
      value = 10 * value + (text_[at_++] - '0');
    }
    return value;
  }
  bool take(std::string_view any_of) {
    if (at_ >= text_.size() || any_of.find(text_[at_]) == std::string_view::npos) return false;
    ++at_;
    return true;
  }
  void need(std::string_view any_of) { failed_ = failed_ || !take(any_of); }
  void skip_digits() {
    while (take("0123456789")) {
    }
  }
  [[nodiscard]] bool done() const { return at_ == text_.size(); }
  [[nodiscard]] bool ok() const { return !failed_; }
  [[nodiscard]] char last() const { return text_[at_ - 1]; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

/// Parses "Z", "+01:00" or "-0130" into seconds east.
std::int64_t offset_east_s(DateScanner& scan) {
  if (scan.take("Zz")) return 0;
  scan.need("+-");
  if (!scan.ok()) return 0;
  const int sign = scan.last() == '-' ? -1 : 1;
  const int hours = scan.digits(2);
  (void)scan.take(":");
  return sign * (std::int64_t{3600} * hours + std::int64_t{60} * scan.digits(2));
}

}  // namespace

std::optional<std::int64_t> utc_seconds(std::string_view text) {
  DateScanner scan(text);
  const int year = scan.digits(4);
  scan.need("-");
  const int month = scan.digits(2);
  scan.need("-");
  const int day = scan.digits(2);
  const std::chrono::year_month_day date{std::chrono::year{year},
                                         std::chrono::month{static_cast<unsigned>(month)},
                                         std::chrono::day{static_cast<unsigned>(day)}};
  if (!scan.ok() || !date.ok()) return std::nullopt;
  const std::int64_t midnight_s = kSecondsADay * std::chrono::sys_days{date}.time_since_epoch().count();
  if (scan.done()) return midnight_s;
  scan.need("Tt ");
  const int hour = scan.digits(2);
  scan.need(":");
  const int minute = scan.digits(2);
  const int second = scan.take(":") ? scan.digits(2) : 0;
  if (scan.take(".,")) scan.skip_digits();
  const std::int64_t east_s = offset_east_s(scan);
  // 60: a leap second.
  if (!scan.ok() || !scan.done() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
  return midnight_s + 3600 * hour + 60 * minute + second - east_s;
}

std::string utc_text(std::int64_t seconds) {
  const std::int64_t days = seconds / kSecondsADay - (seconds % kSecondsADay < 0 ? 1 : 0),
                     rest = seconds - days * kSecondsADay;
  const std::chrono::year_month_day date{std::chrono::sys_days{std::chrono::days{days}}};
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(rest / 3600), static_cast<int>(rest / 60 % 60), static_cast<int>(rest % 60));
  return text.data();
}

}  // namespace octant
