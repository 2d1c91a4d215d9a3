// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace octant {

/// A cumulative sum that is limited to zero from below (E. S. Page, Biometrika 41, 1954):
///   S <- max(0, S + gain)
/// Gains are negative on average without a change. There is an alarm when the sum exceeds a threshold.
struct CumulativeSum {
  double value = 0.0;

  /// @return false if the sum is zero, so that earlier values no longer matter
  bool add(double gain) noexcept {
    value = std::max(0.0, value + gain);
    return value > 0.0;
  }
};

/// Two-sided cumulative sums of values z that are N(0, 1) without a change: gains z - k upwards, -z - k
/// downwards, alarm beyond h. k is half of the shift, in sigmas, that is to be found fastest.
struct Cusum {
  double k = 0.5;
  double h = 5.0;
  CumulativeSum upper{}, lower{};

  void add(double z) noexcept {
    upper.add(z - k);
    lower.add(-z - k);
  }
  /// +1: values have become larger, -1: smaller, 0: neither.
  [[nodiscard]] int alarm() const noexcept { return upper.value > h ? 1 : lower.value > h ? -1 : 0; }
};

/// Average number of values until a false alarm of the two-sided chart (Siegmund's approximation, Sequential
/// Analysis, 1985; within 3 % for k = 0.5 and h from 3 on).
[[nodiscard]] double run_length(double k, double h);
/// Threshold h for which run_length(k, h) has this value (at least 2).
[[nodiscard]] double cusum_threshold(double k, double run_length);

}  // namespace octant
