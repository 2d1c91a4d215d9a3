// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
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

/// Positions of the vehicles and range of temperatures at the arrivals.
struct LogExtent {
  std::vector<Eigen::Vector2d> places_m;  ///< in the plane; corners of their convex hull are sufficient
  double lowest_m = INFINITY, highest_m = -INFINITY;
  double coldest_degC = INFINITY, hottest_degC = -INFINITY;

  void include(const LogExtent& other) {
    places_m.insert(places_m.end(), other.places_m.begin(), other.places_m.end());
    lowest_m = std::min(lowest_m, other.lowest_m);
    highest_m = std::max(highest_m, other.highest_m);
    coldest_degC = std::min(coldest_degC, other.coldest_degC);
    hottest_degC = std::max(hottest_degC, other.hottest_degC);
  }
};

/// Totals of all epochs of a log of which only a sample is in memory as a trajectory.
struct LogTotals {
  std::size_t stride = 1;
  std::size_t epochs = 0;
  /// Arrivals of each beacon by what became of them.
  std::vector<RejectionCounts> of_beacon;
  LogExtent extent;

  [[nodiscard]] std::size_t used() const {
    std::size_t sum = 0;
    for (const RejectionCounts& counts : of_beacon) sum += counts.of(Rejection::kUsed);
    return sum;
  }
};

}  // namespace octant::calib
