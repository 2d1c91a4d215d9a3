// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>
#include <span>

#include <Eigen/Core>

namespace octant {

inline constexpr int kKleemanBeacons =
    16;  ///< most beacons of a system: the counter on Kleeman's boards has four bits
using BeaconSet = std::bitset<kKleemanBeacons>;

/// Distances from one place to up to 16 beacons, all longer than the true ones by the same unknown amount; an
/// entry a beacon.
struct OffsetDistances {
  std::array<double, kKleemanBeacons> distance_m{};
  std::array<double, kKleemanBeacons> sigma_m{};  ///< of the noise, independent from beacon to beacon
  BeaconSet heard;                                ///< the other entries mean nothing
  BeaconSet rough;  ///< of those heard, much less exact than the others: they check and do not place
};

/// Which distances cannot be direct, by the triangle inequality (L. Kleeman, section 4.3), over all pairs of
/// beacons heard:
///   |Pb0| - |Pb1| < |b0 b1|  (eq. 5),   |Pb1| - |Pb0| < |b0 b1|  (eq. 6)
/// A distance can only be too long, so the longer one is rejected. A distance once rejected goes on being
/// compared: being too long, it can only make the left-hand sides smaller where it is subtracted, and so
/// never rejects a good one.
/// @param beacon_p_map_m  positions by beacon, in space: the inequality holds for slant distances as they are
/// @param sigmas          tolerance, in standard deviations of the difference
/// @param slack_m         tolerance besides, for what is no noise (the size of the receiver array)
[[nodiscard]] BeaconSet triangle_violations(const OffsetDistances& distances,
                                            std::span<const Eigen::Vector3d> beacon_p_map_m, double sigmas,
                                            double slack_m = 0.0);

}  // namespace octant
