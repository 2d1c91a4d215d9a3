// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: counters of receivers that begin again.

#include <array>
#include <cmath>
#include <cstddef>

namespace octant::io {

/// Duration of one tick of a DW1000 [s], and the periods of its counter: 40 bits (17.2 s), and the lower 32
/// bits, which packets of TDoA3 carry (67 ms).
inline constexpr double kTick_s = 1.0 / (128 * 499.2e6);
inline constexpr std::array<double, 2> kCounterPeriods_s = {4294967296.0 * kTick_s,
                                                            1099511627776.0 * kTick_s};

/// Continues the time stamps of a counter. The number of its restarts follows from the time of the log.
class Counter {
 public:
  /// @param period_s  0: the counter does not begin again
  [[nodiscard]] double continued_s(double stamp_s, double time_s, double period_s) {
    if (period_s > 0.0 && known_) {
      const double turns = std::round((time_s - time_s_ - (stamp_s + base_s_ - stamp_s_)) / period_s);
      base_s_ += turns * period_s;
      wraps_ += static_cast<std::size_t>(std::max(0.0, turns));
    }
    known_ = true;
    time_s_ = time_s;
    stamp_s_ = stamp_s + base_s_;
    return stamp_s_;
  }
  [[nodiscard]] std::size_t wraps() const { return wraps_; }

 private:
  bool known_ = false;
  double time_s_ = 0.0, stamp_s_ = 0.0, base_s_ = 0.0;
  std::size_t wraps_ = 0;
};

}  // namespace octant::io
