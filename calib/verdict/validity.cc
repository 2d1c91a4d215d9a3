// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/validity.h"

#include <algorithm>

#include "calib/problem/ranges.h"

namespace octant::calib {

std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  const auto before = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), before);
  if (points.size() < 3) return points;
  const auto turn = [](const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
  };
  std::vector<Eigen::Vector2d> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= base + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

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
