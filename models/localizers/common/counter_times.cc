// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/counter_times.h"

#include <map>
#include <tuple>

namespace octant {

std::vector<Arrival> arrivals_of_counters(std::span<const CounterReading> readings, double spread_s,
                                          double clock_hz) {
  struct Group {
    const CounterReading* first;
    std::vector<double> time_s;
  };
  // Values are grouped by epoch, or by time if there are no epochs.
  using Key = std::tuple<std::int64_t, double, BeaconId, ReceiverId>;
  std::map<Key, std::size_t> group_of;
  std::vector<Group> groups;
  for (const CounterReading& r : readings) {
    const Key key{r.epoch, r.epoch == kNoEpoch ? r.time_s : 0.0, r.beacon, r.receiver};
    const auto [at, added] = group_of.try_emplace(key, groups.size());
    if (added) groups.push_back({&r, {}});
    groups[at->second].time_s.push_back(counter_time_s(r.counts, clock_hz));
  }
  std::vector<Arrival> arrivals;
  for (const Group& group : groups) {
    Arrival a;
    a.time_s = group.first->time_s;
    a.tof_s = mean_of_agreeing(group.time_s, spread_s).mean;
    a.beacon = group.first->beacon;
    a.receiver = group.first->receiver;
    a.vehicle = VehicleId(0);
    a.epoch = group.first->epoch;
    a.line = group.first->line;
    arrivals.push_back(a);
  }
  return arrivals;
}

}  // namespace octant
