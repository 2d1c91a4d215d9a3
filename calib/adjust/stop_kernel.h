// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace octant::calib {

/// Epochs are worked on eight at a time, one in each lane; narrower machines take the eight in turns.
inline constexpr std::size_t kLanes = 8;

/// A number of each of eight epochs.
struct alignas(64) Lanes {
  double of[kLanes] = {};
};

/// The evaluation point as flat tables. All beacon and receiver entries are x, y, z [m] and delay [s]; a
/// site's one delay is on the beacons. All arrivals have one sigma.
struct StopTables {
  const double* beacon = nullptr;    ///< beacons of the site x 4
  const double* receiver = nullptr;  ///< receivers of the vehicle x 4
  double speed_mps = 343.0;          ///< of the medium where arrivals carry none, offset included
  double speed_offset_mps = 0.0;     ///< added to an arrival's own
  double sigma_s = 1.0;
  double late_scale = 0.0, early_scale = 0.0;  ///< of RobustLoss
  bool has_offset = false;                     ///< Clock::kCycleOffset
  double nominal_speed_mps = 343.0;            ///< turns cycle offsets into metres
};

/// Which path the arrivals of a slot took.
struct StopSlot {
  std::uint16_t beacon = 0;    ///< index into StopPack::beacons
  std::uint16_t receiver = 0;  ///< of the vehicle
};

/// Measured poses of eight epochs: x, y [m] and heading [rad], and 1 / sigma^2 of each; weight 0: not
/// measured.
struct StopPoses {
  Lanes value[3], weight[3];
};

/// Eight epochs turned sideways: a slot holds the arrivals of all lanes over one path. Slots of one receiver
/// follow each other.
struct StopPack {
  std::size_t slots = 0;
  const StopSlot* slot = nullptr;
  const Lanes* tof_s = nullptr;            ///< of each slot; NaN: the epoch did not hear that path
  const Lanes* model_speed_mps = nullptr;  ///< of each slot, or null
  const std::int32_t* beacons = nullptr;   ///< of the group, in the site's numbers
  const StopPoses* poses = nullptr;        ///< or null
};

/// State of eight epochs.
struct StopStates {
  Lanes value[4];  ///< x, y [m], heading [rad], cycle offset [m]
};

struct StopOutcome {
  Lanes cost;       ///< 1/2 sum of rho
  Lanes converged;  ///< 1: at rest; 0: not, or singular: to be settled with care
};

/// Gauss-Newton steps (damped where the cost would rise) on the states of eight epochs, as `settle` does for
/// one.
void settle_stops(const StopTables& tables, const StopPack& pack, StopStates& states, StopOutcome& outcome);

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

/// What the packs of a group add up to. All lists stand in fours.
struct StopSums {
  /// Moments of a path with the derivative v of its residual by the place of the receiver, and s by the
  /// speed: sums of
  ///   w, w v (3), w v v' (6: 00 01 02 11 12 22), w s, w r, w s v (3), -, w r v (3), -
  static constexpr std::size_t kMoments = 20;
  static constexpr std::size_t kReceiver =
      20;  ///< upper triangle of 4 x 4, with the speed (4), gradient (4), -, -
  static constexpr std::size_t kPair = 16;  ///< 4 x 4, rows by the beacon
  static constexpr std::size_t kBlock = 4;  ///< rows and columns of a block of what is taken away
  static constexpr std::size_t kPacksAtOnce = 4;

  std::vector<double> beacon;    ///< beacons x kMoments
  std::vector<double> receiver;  ///< receivers x kReceiver
  std::vector<double> pair;      ///< (beacons x receivers) x kPair
  std::vector<double>
      taken;  ///< what the states take away from the active columns: blocks of the upper triangle
  std::vector<double> taken_gradient;  ///< and from their gradient
  double speed_curvature = 0.0, speed_gradient = 0.0;

  bool has_offset = false;          ///< states of four instead of three
  std::vector<std::size_t> active;  ///< columns, filled up to fours with one that is zero
  std::vector<Lanes> coupling;      ///< of one pack: columns x 4
  /// Rows Y of what is to be taken away as Y'Y: some packs together, so that the blocks are loaded and stored
  /// less often.
  std::vector<Lanes> rows;  ///< active columns x packs x states
  std::size_t waiting = 0;  ///< packs in `rows`

  /// Zero, and of the layout's size.
  void clear(const StopLayout& layout, bool has_offset);
  /// The reduced system: upper right triangle of H (columns x columns) and the gradient. Only the active
  /// columns mean anything.
  void finish(const StopLayout& layout, double sigma_s, std::vector<double>& H,
              std::vector<double>& gradient);
};

/// Adds eight epochs, reduced to the parameters of their group by elimination of their states.
/// @param unobserved  floor under the information of a state's direction, of the largest diagonal element
void reduce_stops(const StopTables& tables, const StopPack& pack, const StopStates& states,
                  const StopLayout& layout, double unobserved, StopSums& sums);

/// Name of the vector instructions in use, chosen when the program runs.
const char* stop_kernel_target();

}  // namespace octant::calib
