// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"

namespace octant::calib {

inline constexpr std::size_t kRejections = static_cast<std::size_t>(Rejection::kNotNeeded) + 1;

/// What is told of all epochs of a log of which only every so many-th is at hand as a trajectory, because the
/// whole would not fit into memory.
struct LogTotals {
  std::size_t stride = 1;
  std::size_t epochs = 0;
  /// Arrivals of each beacon by what became of them.
  std::vector<std::array<std::size_t, kRejections>> of_beacon;
  std::vector<Eigen::Vector2d> area_m;  ///< corners of the convex hull of all places
  double coldest_degC = INFINITY, hottest_degC = -INFINITY;

  [[nodiscard]] std::size_t count(std::size_t beacon, Rejection what) const {
    return of_beacon[beacon][static_cast<std::size_t>(what)];
  }
  [[nodiscard]] std::size_t used() const {
    std::size_t sum = 0;
    for (const auto& counts : of_beacon) sum += counts[static_cast<std::size_t>(Rejection::kUsed)];
    return sum;
  }
};

}  // namespace octant::calib
