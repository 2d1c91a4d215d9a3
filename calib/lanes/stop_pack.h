// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

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
  double speed_mps = 343.0;          ///< speed of the medium for arrivals without one, offset included
  double speed_offset_mps = 0.0;     ///< added to an arrival's own
  double sigma_s = 1.0;
  double late_scale = 0.0, early_scale = 0.0;  ///< of RobustLoss
  bool has_offset = false;                     ///< Clock::kCycleOffset
  double nominal_speed_mps = 343.0;            ///< turns cycle offsets into metres
};

/// Path of the arrivals of a slot.
struct StopSlot {
  std::uint16_t beacon = 0;    ///< index into StopPack::beacons
  std::uint16_t receiver = 0;  ///< receiver of the vehicle
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
  const Lanes* tof_s = nullptr;            ///< times of each slot; NaN: the epoch has no arrival on that path
  const Lanes* model_speed_mps = nullptr;  ///< speeds of each slot, or null
  const std::int32_t* beacons = nullptr;   ///< beacons of the group, as numbers of the site
  const StopPoses* poses = nullptr;        ///< or null
};

/// State of eight epochs.
struct StopStates {
  Lanes value[4];  ///< x, y [m], heading [rad], cycle offset [m]
};

}  // namespace octant::calib
