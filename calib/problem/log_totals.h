// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

inline constexpr std::size_t kRejections = static_cast<std::size_t>(Rejection::kNotNeeded) + 1;

/// Arrivals by what became of them.
struct RejectionCounts : std::array<std::size_t, kRejections> {
  RejectionCounts() : array{} {}
  void add(Rejection what, std::size_t arrivals = 1) { (*this)[static_cast<std::size_t>(what)] += arrivals; }
  void add(const RejectionCounts& other) {
    for (std::size_t i = 0; i < size(); ++i) (*this)[i] += other[i];
  }
  [[nodiscard]] std::size_t of(Rejection what) const { return (*this)[static_cast<std::size_t>(what)]; }
  [[nodiscard]] std::size_t outliers() const { return of(Rejection::kLate) + of(Rejection::kEarly); }
  [[nodiscard]] std::size_t all() const { return std::accumulate(begin(), end(), std::size_t{0}); }
};

/// Numbers of each beacon, or of each receiver.
/// @param owner  of an arrival, an index below `owners`
template <class Owner>
[[nodiscard]] std::vector<RejectionCounts> count_rejections(const std::vector<Trajectory>& trajectories,
                                                            std::size_t owners, Owner&& owner) {
  std::vector<RejectionCounts> counts(owners);
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals) counts[owner(a)].add(a.rejection);
  return counts;
}
[[nodiscard]] inline std::vector<RejectionCounts> rejections_by_beacon(
    const std::vector<Trajectory>& trajectories, std::size_t beacons) {
  return count_rejections(trajectories, beacons,
                          [](const ArrivalObservation& a) { return a.beacon.index(); });
}

/// Totals of all epochs of a log of which only a sample is in memory as a trajectory.
struct LogTotals {
  std::size_t stride = 1;
  std::size_t epochs = 0;
  /// Arrivals of each beacon by what became of them.
  std::vector<RejectionCounts> of_beacon;
  std::vector<Eigen::Vector2d> area_m;  ///< corners of the convex hull of all places
  double coldest_degC = INFINITY, hottest_degC = -INFINITY;

  [[nodiscard]] std::size_t used() const {
    std::size_t sum = 0;
    for (const RejectionCounts& counts : of_beacon) sum += counts.of(Rejection::kUsed);
    return sum;
  }
};

}  // namespace octant::calib
