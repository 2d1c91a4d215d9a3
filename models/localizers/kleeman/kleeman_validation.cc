// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_validation.h"

#include <cmath>

namespace octant {

BeaconSet triangle_violations(const OffsetDistances& d, std::span<const Eigen::Vector3d> beacon_p_map_m,
                              double sigmas, double slack_m) {
  BeaconSet violating;
  for (std::size_t i = 0; i < beacon_p_map_m.size(); ++i) {
    for (std::size_t j = 0; j < beacon_p_map_m.size(); ++j) {
      if (i == j || !d.heard[i] || !d.heard[j]) continue;
      const double baseline_m = (beacon_p_map_m[i] - beacon_p_map_m[j]).norm();
      const double tolerance_m = sigmas * std::hypot(d.sigma_m[i], d.sigma_m[j]) + slack_m;
      if (d.distance_m[i] - d.distance_m[j] > baseline_m + tolerance_m)
        violating.set(i);  // eq. 5; eq. 6 with i and j exchanged
    }
  }
  return violating;
}

}  // namespace octant
