// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/observed_range.h"

#include <algorithm>
#include <cmath>

#include "models/physics/range.h"

namespace octant {

double observed_range_m(const Trajectory& t, const ArrivalObservation& a, const SharedState& state,
                        std::optional<double> cycle_offset_s) {
  const PathInput path = path_of(t, a, state);
  FlightTime flight{a.tof_s - path.delay_s, path.speed_mps, a.legs()};
  if (t.has_cycle_offset)
    flight.time_s -=
        state.drift(t.vehicle) * (a.time_s - t.nodes[a.node].time_s) + cycle_offset_s.value_or(0.0);
  const double by_time_mps = flight.speed_mps / flight.legs;
  if (path.log_amplitude) {
    const double share =
        std::min(path.attenuation->threshold_v / std::exp(*path.log_amplitude), kMostMeasuredShare);
    return by_time_mps * (flight.time_s - walk_of_share_s(share, *path.attenuation));
  }
  if (path.attenuation == nullptr || (t.has_cycle_offset && !cycle_offset_s))
    return by_time_mps * flight.time_s;
  return range_with_walk(flight, *path.attenuation, path.log_gain).range_m;
}

}  // namespace octant
