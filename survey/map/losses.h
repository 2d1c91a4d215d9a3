// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "survey/geometry/map_kernel.h"

namespace octant::survey {

/// Loss by the failure of one or two beacons over all poses: cells times headings.
struct Loss {
  std::size_t first = 0, second = kNone;  ///< beacons; second: kNone where one fails
  std::size_t poses_out = 0;              ///< covered before, out of tolerance (or without a fix) after
  std::size_t poses_without_fix = 0;      ///< with a fix before
  double worst_sigma_m = 0.0;             ///< largest that is left where there still is a fix
  std::int64_t spread_ppm = 0;  ///< sum of the relative growth of sigma, capped at 10 a cell: breaks ties
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
};

/// Counts failures, tile by tile, by subtracting a beacon's information from the sum. One object for each
/// thread, merged at the end. Counts are integers, so the result does not depend on the distribution of
/// tiles.
class LossAccount {
 public:
  /// @param at_once  how many may fail together: 0, 1 or 2
  LossAccount(const KernelModel& kernel, int at_once);

  struct Cells {
    std::span<const double> other_m2;    ///< variance besides the arrivals' noise: the calibration's
    double tolerance_m = 0.0;            ///< infinity: only fixes count
    std::span<double> one_m, two_m;      ///< out: worst sigma with one, with two beacons gone (noise alone)
    std::span<std::int32_t> one_beacon;  ///< out: index of the beacon; -1: no failure matters
  };
  void add(const KernelModel& kernel, const KernelTile& tile, const Cells& cells);
  void merge(const LossAccount& other);

  /// Single beacons, all of them, the one that matters most first.
  [[nodiscard]] std::vector<Loss> singles() const;
  /// Pairs with a loss, worst first, at most `most`.
  [[nodiscard]] std::vector<Loss> pairs(std::size_t most) const;

 private:
  void count(const double* before, const double* after, const Cells& cells, std::size_t size,
             Loss& loss) const;
  [[nodiscard]] std::size_t pair_index(std::size_t a, std::size_t b) const {
    return a * (2 * beacons_ - a - 1) / 2 + (b - a - 1);
  }

  std::size_t beacons_;
  int at_once_;
  std::vector<Loss> singles_, pairs_;
  std::vector<double> layers_, heard_, total_;  ///< scratch: a layer for each beacon
};

}  // namespace octant::survey
