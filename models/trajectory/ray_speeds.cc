// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/ray_speeds.h"

#include <algorithm>
#include <cmath>

#include "models/trajectory/linearise.h"

namespace octant {

double set_ray_speeds(Trajectory& t, const SharedState& state, const SpeedProfile& profile) {
  double largest_m = 0.0;
  for (ArrivalObservation& a : t.arrivals) {
    if (!t.nodes[a.node].placed) continue;
    const Eigen::Vector3d receiver_m =
        pose_at(t, a.node, a.alpha) * state.receiver_p_vehicle_m[a.receiver.index()];
    const Eigen::Vector3d& beacon_m = state.beacon_p_map_m[a.beacon.index()];
    const double speed_mps = profile.effective_speed_mps(receiver_m, beacon_m);
    largest_m =
        std::max(largest_m, (receiver_m - beacon_m).norm() * std::abs(a.model_speed_mps / speed_mps - 1));
    a.model_speed_mps = speed_mps;
  }
  return largest_m;
}

}  // namespace octant
