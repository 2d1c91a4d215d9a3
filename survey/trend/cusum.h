// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant::survey {

/// Two-sided cumulative sums of values z that are N(0, 1) as long as nothing changes (E. S. Page, Biometrika
/// 41, 1954):
///   upper <- max(0, upper + z - k),  lower <- max(0, lower - z - k),  alarm beyond h.
/// k is half of the shift, in sigmas, that is to be found fastest.
struct Cusum {
  double k = 0.5;
  double h = 5.0;
  double upper = 0.0, lower = 0.0;

  void add(double z);
  /// +1: values have become larger, -1: smaller, 0: neither.
  [[nodiscard]] int alarm() const { return upper > h ? 1 : lower > h ? -1 : 0; }
};

/// Values until an alarm of the two-sided chart where nothing changes, on average (Siegmund's approximation,
/// Sequential Analysis, 1985; within 3 % for k = 0.5 and h from 3 on).
[[nodiscard]] double run_length(double k, double h);
/// The h of which run_length is as long as this (at least 2).
[[nodiscard]] double cusum_threshold(double k, double run_length);

}  // namespace octant::survey
