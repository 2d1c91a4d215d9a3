// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/validity.h"

#include <algorithm>

#include "calib/problem/ranges.h"

namespace octant::calib {

void LogExtent::add(const Trajectory& t, const MeasurementLog& run, const Site& site) {
  for (const Node& node : t.nodes)
    if (node.placed) places_m.emplace_back(node.T_map_vehicle.translation_m.head<2>());
  for (const ArrivalObservation& a : t.arrivals) {
    const double degC = temperature_degC(run.arrivals[a.arrival], run, site);
    coldest_degC = std::min(coldest_degC, degC);
    hottest_degC = std::max(hottest_degC, degC);
  }
}

}  // namespace octant::calib
