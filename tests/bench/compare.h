// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace octant::bench {

/// Two builds of the benchmarks, run alternately: machines are shared, so figures from different hours are
/// not comparable.
struct Comparison {
  std::string now, base;             ///< programs
  std::vector<std::string> options;  ///< arguments of Google Benchmark for both
};

/// Prints each benchmark's processor time in both, medians of five turns.
/// @return 0; 1 where one is more than 15 % slower now; 2 where a program does not run
int compare(const Comparison& asked);

}  // namespace octant::bench
