// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/lanes/stop_pack.h"

namespace octant::calib {

/// Columns of the system of a group of packs that share their beacons: four for each beacon, four for each
/// receiver (x, y, z, delay each), the speed. Derivatives are by metres and seconds and metres a second.
struct StopLayout {
  std::size_t beacons = 0, receivers = 0;
  bool receivers_free = false;  ///< any column of a receiver is active
  std::vector<std::size_t>
      active;  ///< columns that are adjusted, ascending; of the others only rubbish comes out
  [[nodiscard]] std::size_t of_receiver(std::size_t r) const { return 4 * (beacons + r); }
  [[nodiscard]] std::size_t speed() const { return 4 * (beacons + receivers); }
  [[nodiscard]] std::size_t columns() const { return speed() + 1; }
};

/// Sum of the packs of a group. All lists have multiples of four.
struct StopSums {
  /// Moments of a path with the derivative v of its residual by the place of the receiver, and s by the
  /// speed: sums of
  ///   w, w v (3), w v v' (6: 00 01 02 11 12 22), w s, w r, w s v (3), -, w r v (3), -
  static constexpr std::size_t kMoments = 20;
  static constexpr std::size_t kReceiver =
      20;  ///< upper triangle of 4 x 4, with the speed (4), gradient (4), -, -
  static constexpr std::size_t kPair = 16;  ///< 4 x 4, rows by the beacon
  static constexpr std::size_t kBlock = 4;  ///< rows and columns of a block of the subtracted matrix
  static constexpr std::size_t kPacksAtOnce = 4;

  std::vector<double> beacon;    ///< beacons x kMoments
  std::vector<double> receiver;  ///< receivers x kReceiver
  std::vector<double> pair;      ///< (beacons x receivers) x kPair
  std::vector<double> schur;  ///< subtracted matrix of the active columns by the elimination of the states:
                              ///< blocks of the upper triangle
  std::vector<double> schur_gradient;  ///< and from their gradient
  double speed_curvature = 0.0, speed_gradient = 0.0;

  bool has_offset = false;          ///< states of four instead of three
  std::vector<std::size_t> active;  ///< columns, filled up to fours with one that is zero
  std::vector<Lanes> coupling;      ///< coupling of one pack: columns x 4
  /// Rows Y of the subtracted matrix Y'Y: several packs together, so that the blocks are loaded and stored
  /// less often.
  std::vector<Lanes> rows;  ///< active columns x packs x states
  std::size_t waiting = 0;  ///< packs in `rows`

  /// Zero, and of the layout's size.
  void clear(const StopLayout& layout, bool has_offset);
  /// The reduced system: upper right triangle of H (columns x columns) and the gradient. Only the active
  /// columns are valid.
  void finish(const StopLayout& layout, double sigma_s, std::vector<double>& H,
              std::vector<double>& gradient);
};

/// Adds eight epochs, reduced to the parameters of their group by elimination of their states.
/// @param unobserved  floor under the information of a state's direction, of the largest diagonal element
void reduce_stops(const StopTables& tables, const StopPack& pack, const StopStates& states,
                  const StopLayout& layout, double unobserved, StopSums& sums);

}  // namespace octant::calib
