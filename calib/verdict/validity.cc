// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/validity.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "calib/problem/ranges.h"
#include "calib/verdict/hearing_pairs.h"
#include "models/physics/polygon.h"

namespace octant::calib {

LogExtent extent_of(const Trajectory& t, const MeasurementLog& run, const Site& site) {
  LogExtent extent;
  for (const Node& node : t.nodes) {
    if (!node.placed) continue;
    const Eigen::Vector3d& p = node.T_map_vehicle.translation_m;
    extent.places_m.emplace_back(p.head<2>());
    extent.lowest_m = std::min(extent.lowest_m, p.z());
    extent.highest_m = std::max(extent.highest_m, p.z());
  }
  for (const ArrivalObservation& a : t.arrivals) {
    const double degC = temperature_degC(run.arrivals[a.arrival], run, site);
    extent.coldest_degC = std::min(extent.coldest_degC, degC);
    extent.hottest_degC = std::max(extent.hottest_degC, degC);
  }
  return extent;
}

void set_valid_space(LogExtent extent, Deployment& d) {
  d.validity_area_m = convex_hull(std::move(extent.places_m));
  if (d.motion == Motion::kSpatial && extent.lowest_m <= extent.highest_m)
    d.validity_heights_m = {extent.lowest_m, extent.highest_m};
}

std::optional<double> heard_reach_m(const std::vector<Trajectory>& trajectories,
                                    const std::vector<DeploymentBeacon>& beacons) {
  constexpr std::size_t kMostPairs = 2'000'000;  // a sample of a long log is sufficient
  constexpr std::size_t kEnoughHeard = 200;
  constexpr double kStrays = 0.005, kMissed = 20.0, kNextToNothing = 0.05;
  std::size_t all = 0;
  for (const Trajectory& t : trajectories) all += t.nodes.size() * beacons.size();
  const auto for_all_pairs = [&](const auto& take) {
    const auto is_used = [](const ArrivalObservation& a) { return a.rejection == Rejection::kUsed; };
    for (const Trajectory& t : trajectories)
      for_each_hearing_pair(t, beacons, all / kMostPairs + 1, is_used, take);
  };
  std::vector<double> heard_m;
  for_all_pairs([&](std::size_t, double distance_m, bool heard) {
    if (heard) heard_m.push_back(distance_m);
  });
  if (heard_m.size() < kEnoughHeard) return {};
  const auto strays = static_cast<std::size_t>(kStrays * static_cast<double>(heard_m.size()));
  const double reach_m = nth_smallest(heard_m, heard_m.size() - 1 - strays);
  double within = 0, within_heard = 0, beyond = 0, beyond_heard = 0;
  for_all_pairs([&](std::size_t, double distance_m, bool heard) {
    (distance_m <= reach_m ? within : beyond) += 1;
    if (heard) (distance_m <= reach_m ? within_heard : beyond_heard) += 1;
  });
  const double expected = beyond * within_heard / within;
  if (expected - beyond_heard < kMissed || beyond_heard > kNextToNothing * expected) return {};
  return reach_m;
}

}  // namespace octant::calib
