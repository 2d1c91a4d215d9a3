// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "models/live/follower.h"

namespace octant {

/// Lets the watch follow the tracker; it stops if odometry is missing.
void Follower::watch_motion(Lane& lane) {
  if (!lane.watch || !lane.tracker) return;
  lane.watch->stop();
  lane.tracker->set_motion_sink([watch = lane.watch.get()](const OdometryObservation* motion) {
    if (motion == nullptr) return watch->stop();
    watch->move(*motion);
  });
}

std::span<const Arrival> Follower::still_in_use(const Lane& lane, std::span<const Arrival> arrivals) {
  const auto is_out = [&](const Arrival& a) {
    return lane.watch->is_out(a.beacon) || lane.watch->is_out(a.receiver);
  };
  if (!lane.watch || std::ranges::none_of(arrivals, is_out)) return arrivals;
  in_use_.clear();
  std::ranges::remove_copy_if(arrivals, std::back_inserter(in_use_), is_out);
  return in_use_;
}

}  // namespace octant
