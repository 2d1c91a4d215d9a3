// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/conditions.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "calib/problem/ranges.h"
#include "calib/verdict/reach.h"
#include "calib/verdict/validity.h"
#include "models/physics/polygon.h"

namespace octant::calib {

MediumFound thermometer_of(const Deployment& d, const std::vector<MeasurementLog>& runs) {
  MediumFound out;
  double sum = 0.0;
  std::size_t count = 0, all = 0;
  for (const MeasurementLog& run : runs)
    for (const Arrival& a : run.arrivals) {
      ++all;
      const std::optional<double> degC = measured_temperature_degC(a, run);
      if (!degC) continue;
      sum += *degC;
      ++count;
    }
  out.temperature_known = d.medium.model == MediumModel::kConstant || count == all;
  out.temperature_degC = count > 0 ? sum / static_cast<double>(count) : d.medium.temperature_degC;
  return out;
}

void extend_validity(Deployment& d, const std::vector<Trajectory>& trajectories, const Problem& problem,
                     bool temperature_known) {
  LogExtent extent{d.validity_area_m};
  for (const Trajectory& t : trajectories) extent.add(t, problem.runs[t.run], problem.site);
  if (d.validity_temperature_degC && temperature_known) {
    auto& [coldest, hottest] = *d.validity_temperature_degC;
    coldest = std::min(coldest, extent.coldest_degC);
    hottest = std::max(hottest, extent.hottest_degC);
  }
  d.validity_area_m = convex_hull(std::move(extent.places_m));
  if (const auto now_m = heard_reach_m(trajectories, d.beacons))
    d.validity_reach_m = std::max(*now_m, d.validity_reach_m.value_or(0.0));
}

}  // namespace octant::calib
