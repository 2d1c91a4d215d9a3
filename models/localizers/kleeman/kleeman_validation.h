// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>
#include <span>

#include <Eigen/Core>

namespace octant {

inline constexpr int kKleemanBeacons =
    16;  ///< largest number of beacons: the counter on Kleeman's boards has four bits
using BeaconSet = std::bitset<kKleemanBeacons>;

/// Distances from one position to up to 16 beacons, all with the same unknown excess; one entry for each
/// beacon.
struct OffsetDistances {
  std::array<double, kKleemanBeacons> distance_m{};
  std::array<double, kKleemanBeacons> sigma_m{};  ///< noise, independent between beacons
  BeaconSet heard;                                ///< beacons with a valid entry
  BeaconSet rough;  ///< beacons whose distances are much less accurate: they are used as checks only
};

/// Finds distances that cannot be direct, by the triangle inequality (L. Kleeman, section 4.3) for all pairs
/// of received beacons:
///   |Pb0| - |Pb1| < |b0 b1|  (eq. 5),   |Pb1| - |Pb0| < |b0 b1|  (eq. 6)
/// A distance can only be too long, so the longer one is rejected. Rejected distances remain in the
/// comparison. Being too long, they only decrease the left-hand sides in which they are subtracted, so they
/// never reject a good distance.
/// @param beacon_p_map_m  positions of the beacons in space: the inequality holds for slant distances
/// @param sigmas          tolerance in standard deviations of the difference
/// @param slack_m         additional tolerance for systematic effects (the size of the receiver array)
[[nodiscard]] BeaconSet triangle_violations(const OffsetDistances& distances,
                                            std::span<const Eigen::Vector3d> beacon_p_map_m, double sigmas,
                                            double slack_m = 0.0);

}  // namespace octant
