// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: clocks that start again, and times in another unit than seconds.

#include <array>
#include <cstddef>
#include <optional>
#include <string>

namespace octant::io {

/// Longest gap across a restart, as a part of the clock's period.
inline constexpr double kLongestGapOfPeriod = 0.01;

/// Name and period of the clock by whose restart the time steps from `from_s` back to `to_s`.
struct ClockPeriod {
  double period_s;
  const char* kind;
};
[[nodiscard]] std::optional<ClockPeriod> restarted_clock(double from_s, double to_s);

/// Continues a clock that starts again: a 32-bit counter of microseconds or milliseconds, the time of day.
/// A step back by one period of such a clock, less at most one hundredth of it, is a restart; the later rows
/// are that period later. Any other step back happens by chance in one of a hundred cases, and is an error of
/// the file. The first restart decides which of the clocks it is. If the clock is known, each step back by
/// more than half of its period is a restart.
class ContinuedClock {
 public:
  ContinuedClock() = default;
  explicit ContinuedClock(const std::optional<ClockPeriod>& known) : known_(known) {}

  /// Time of a row on the continued clock.
  /// @param time_s  as the row states it
  /// @param last_s  time of the row before it, on the continued clock
  /// @param line    of the row, for the note; 0: not known
  [[nodiscard]] double continued(double time_s, double last_s, int line);

  [[nodiscard]] double offset_s() const { return offset_s_; }  ///< added to the times at present
  [[nodiscard]] double period_s() const { return period_s_; }  ///< 0: the clock has not started again
  /// One sentence about the restarts of a file; no value without restarts.
  [[nodiscard]] std::optional<std::string> note(const std::string& file) const;

 private:
  [[nodiscard]] bool is_restart(double step_s) const;

  std::optional<ClockPeriod> known_;
  double period_s_ = 0.0, offset_s_ = 0.0;
  const char* kind_ = "";
  int first_line_ = 0;
  double from_s_ = 0.0, to_s_ = 0.0;  // around the first restart
  std::size_t restarts_ = 0;
};

/// Recognises times in milliseconds, microseconds or nanoseconds: whole numbers over more than a day, most
/// steps of which are longer than the usual time between two measurements of a device.
class TimeUnitCheck {
 public:
  void add(double time_s);
  /// One sentence that names the unit; no value if the times may be seconds.
  [[nodiscard]] std::optional<std::string> note(const std::string& file) const;

 private:
  static constexpr std::size_t kDecades = 19;
  bool whole_ = true, begun_ = false;
  double first_s_ = 0.0, last_s_ = 0.0;
  std::size_t steps_ = 0;
  std::array<std::size_t, kDecades> by_decade_{};  // steps of 1 to 10 s, of 10 to 100 s, ...
};

}  // namespace octant::io
