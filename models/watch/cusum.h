// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace octant {

/// A cumulative sum that begins anew wherever it would fall below zero (E. S. Page, Biometrika 41, 1954):
///   S <- max(0, S + gain)
/// Gains are negative on average as long as nothing changes; an alarm is where the sum passes a threshold.
struct CumulativeSum {
  double value = 0.0;

  /// False: it stands at zero, and what led up to here says nothing any more.
  bool add(double gain) noexcept {
    value = std::max(0.0, value + gain);
    return value > 0.0;
  }
};

/// Two-sided cumulative sums of values z that are N(0, 1) as long as nothing changes: gains z - k upwards,
/// -z - k downwards, alarm beyond h. k is half of the shift, in sigmas, that is to be found fastest.
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

/// Values until an alarm of the two-sided chart where nothing changes, on average (Siegmund's approximation,
/// Sequential Analysis, 1985; within 3 % for k = 0.5 and h from 3 on).
[[nodiscard]] double run_length(double k, double h);
/// The h of which run_length is as long as this (at least 2).
[[nodiscard]] double cusum_threshold(double k, double run_length);

}  // namespace octant
