// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "models/deployment.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Arrivals of each pair of beacon and receiver that share a correlated error. Weights of a filter are those
/// of independent errors. The share of an arrival in the error therefore grows with the number of earlier
/// arrivals within the correlation time, and counts in both directions: 1 + 2 sum rho.
class RecentPairs {
 public:
  RecentPairs() = default;
  RecentPairs(std::size_t beacons, std::size_t receivers)
      : receivers_(receivers), pairs_(beacons * receivers) {}
  void clear() { std::ranges::fill(pairs_, Pair{}); }
  /// Returns the variance that an arrival has in addition to its own.
  double add(const ArrivalObservation& a, const CorrelatedNoise& noise) {
    if (pairs_.empty()) return 0.0;
    Pair& pair = pairs_[a.beacon.index() * receivers_ + a.receiver.index()];
    const double dt_s = std::abs(a.time_s - pair.time_s);
    pair.sum *= noise.time_s > 0 ? std::exp(-dt_s / noise.time_s) : dt_s > 0 ? 0.0 : 1.0;
    const double more = 2.0 * pair.sum * noise.sigma_s * noise.sigma_s;
    pair.sum += 1.0;
    pair.time_s = a.time_s;
    return more;
  }

 private:
  struct Pair {
    double time_s = 0.0, sum = 0.0;  ///< number of arrivals, weighted by the correlation time
  };
  std::size_t receivers_ = 0;
  std::vector<Pair> pairs_;
};

}  // namespace octant
