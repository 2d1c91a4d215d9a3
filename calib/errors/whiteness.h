// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Test whether residuals are the white noise that formal sigmas assume, or errors that are constant for a
/// pair or a position (reflections, antennas), which do not average out.
struct Whiteness {
  std::size_t pairs = 0;  ///< beacon-receiver pairs with enough arrivals
  double pair_ratio =
      1.0;  ///< mean of n m^2 / s^2 over the pairs, m the pair's mean residual: 1 for white noise
  double autocorrelation =
      0.0;                     ///< correlation of residuals that are neighbours in time within a pair, pooled
  std::size_t neighbours = 0;  ///< number of such neighbours
  /// Factor by which formal sigmas of averages over a drive are too small: sqrt((1 + rho) / (1 - rho)), at
  /// least 1.
  double sigma_factor = 1.0;
  bool white = true;  ///< false if one is significant (one in a million) and relevant
  /// Factor on the variances of white noise by the correlation within pairs, where an error model is not
  /// affordable.
  [[nodiscard]] double variance_factor() const {
    return white ? 1.0 : std::max({1.0, sigma_factor * sigma_factor, pair_ratio});
  }
};

[[nodiscard]] Whiteness whiteness_of(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                     int threads = 1);

}  // namespace octant::calib
