// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/continued_clock.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "io/text/text.h"
#include "io/text/time_text.h"

namespace octant::io {
namespace {

constexpr ClockPeriod kClocks[] = {{1099511627776.0 / (128 * 499.2e6), "the 40-bit counter of a UWB radio"},
                                   {4294.967296, "a 32-bit counter of microseconds"},
                                   {86400.0, "the time of day"},
                                   {604800.0, "the time of the week"},
                                   {4294967.296, "a 32-bit counter of milliseconds"},
                                   {4294967296.0, "a 32-bit counter"}};

bool is_back_by(double step_s, double period_s) {
  return step_s < 0.0 && step_s > -period_s && step_s <= -(1.0 - kLongestGapOfPeriod) * period_s;
}

constexpr double kLongestWait_s = 10.0;  // between measurements of a device, as a rule
constexpr double kDay_s = 86400.0;
constexpr std::size_t kLeastSteps = 20;

}  // namespace

std::optional<ClockPeriod> restarted_clock(double from_s, double to_s) {
  for (const ClockPeriod& clock : kClocks)
    if (is_back_by(to_s - from_s, clock.period_s)) return clock;
  return std::nullopt;
}

bool ContinuedClock::is_restart(double step_s) const {
  return known_ ? step_s < -0.5 * period_s_ : is_back_by(step_s, period_s_);
}

double ContinuedClock::continued(double time_s, double last_s, int line) {
  const double step_s = time_s + offset_s_ - last_s;
  if (step_s < 0.0) {
    auto clock = restarts_ > 0 ? std::nullopt : known_ ? known_ : restarted_clock(last_s, time_s);
    if (known_ && clock && step_s >= -0.5 * clock->period_s) clock.reset();
    if (clock) {
      period_s_ = clock->period_s;
      kind_ = clock->kind;
      first_line_ = line;
      from_s_ = last_s;
      to_s_ = time_s;
    }
    if (clock || (restarts_ > 0 && is_restart(step_s))) {
      offset_s_ += period_s_;
      ++restarts_;
    }
  } else if (offset_s_ > 0.0 && is_restart(-step_s)) {
    offset_s_ -= period_s_;  // a row from before the restart that was written after it
  }
  return time_s + offset_s_;
}

std::optional<std::string> ContinuedClock::note(const std::string& file) const {
  if (restarts_ == 0) return std::nullopt;
  return fmt::format(
      "{}{}: time_s starts again at {} after {}, as {} does{}; it is continued by adding {} s", file,
      first_line_ > 0 ? fmt::format(":{}", first_line_) : "", exact(to_s_), exact(from_s_), kind_,
      restarts_ > 1 ? fmt::format(" ({} times in this file)", restarts_) : "", exact(period_s_));
}

void TimeUnitCheck::add(double time_s) {
  if (!whole_) {
    last_s_ = time_s;
    return;
  }
  whole_ = time_s == std::floor(time_s);
  const double step_s = time_s - last_s_;
  if (begun_ && step_s >= 1.0) {
    ++steps_;
    const double decade = std::min(std::log10(step_s), static_cast<double>(kDecades - 1));
    ++by_decade_[static_cast<std::size_t>(decade)];
  }
  if (!begun_) first_s_ = time_s;
  begun_ = true;
  last_s_ = time_s;
}

std::optional<std::string> TimeUnitCheck::note(const std::string& file) const {
  static constexpr const char* kUnits[] = {"milliseconds", "microseconds", "nanoseconds"};
  const auto advice = [](std::size_t of) {
    return fmt::format(
        "these seem to be {}; seconds are expected. Divide time_s by 1e{}, here and in the other files "
        "of the recording",
        kUnits[of], 3 * (of + 1));
  };
  std::size_t unit = 0, decade = 0;
  if (whole_ && steps_ >= kLeastSteps && last_s_ - first_s_ >= kDay_s) {
    for (std::size_t below = by_decade_[0]; 2 * below < steps_; below += by_decade_[++decade]) continue;
    const double step_s = std::pow(10.0, static_cast<double>(decade));
    if (step_s < kLongestWait_s) return std::nullopt;
    while (unit < 2 && step_s * std::pow(1e-3, static_cast<double>(unit) + 1.0) >= kLongestWait_s) ++unit;
    return fmt::format(
        "{}: time_s has whole numbers over {:.3g} days, most of which are {} or more apart: {}", file,
        (last_s_ - first_s_) / kDay_s, exact(step_s), advice(unit));
  }
  const double stamp = last_s_ / seconds_of_stamp(last_s_);
  if (!(stamp > 1.0) || stamp > 1e10) return std::nullopt;
  while (unit < 2 && stamp > std::pow(1e3, static_cast<double>(unit) + 1.5)) ++unit;
  return fmt::format("{}: time_s reaches {}, more than any time stamp in seconds: {}", file, exact(last_s_),
                     advice(unit));
}

}  // namespace octant::io
