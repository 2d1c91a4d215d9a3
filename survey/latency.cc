// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/latency.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace octant::survey {
namespace {

/// Epoch of a vehicle, or its instant if there is no epoch.
using Instant = std::tuple<VehicleId, std::int64_t, double>;
template <class Row>
Instant instant_of(const Row& row) {
  return {row.vehicle, row.epoch, row.epoch == kNoEpoch ? row.time_s : 0.0};
}

}  // namespace

std::vector<double> latencies_s(std::span<const Fix> fixes, const MeasurementLog& log) {
  std::map<Instant, double> received_s;
  for (const Arrival& a : log.arrivals) {
    if (!std::isfinite(a.received_after_s)) continue;
    double& last_s = received_s.try_emplace(instant_of(a), a.time_s + a.received_after_s).first->second;
    last_s = std::max(last_s, a.time_s + a.received_after_s);
  }
  std::vector<double> latencies;
  for (const Fix& fix : fixes) {
    if (!fix.ok()) continue;
    const auto last = received_s.find(instant_of(fix));
    if (last != received_s.end()) latencies.push_back(last->second - fix.time_s);
  }
  return latencies;
}

}  // namespace octant::survey
