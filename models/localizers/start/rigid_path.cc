// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/rigid_path.h"

#include <algorithm>
#include <cmath>

namespace octant {

RigidPath rigid_path(const Trajectory& t, const Segment& window, std::size_t anchor) {
  RigidPath path;
  path.first_node = window.first_node;
  const std::size_t n = window.last_node - window.first_node, a = anchor - window.first_node;
  path.T_anchor_node.resize(n);
  path.drift_m.assign(n, 0.0);
  double distance_m2 = 0.0, heading_rad2 = 0.0;
  const auto extend = [&](std::size_t from, std::size_t to, const OdometryObservation& o) {
    path.T_anchor_node[to] =
        path.T_anchor_node[from] * (to > from ? o.T_before_after : o.T_before_after.inverse());
    distance_m2 += o.distance_sigma_m * o.distance_sigma_m;
    heading_rad2 += o.heading_sigma_rad * o.heading_sigma_rad;
    // A heading error acts over the remaining distance; one third of its square is the mean for errors along
    // the way.
    path.drift_m[to] =
        std::sqrt(distance_m2 + heading_rad2 * path.T_anchor_node[to].translation_m.squaredNorm() / 3);
  };
  for (std::size_t k = a + 1; k < n; ++k) extend(k - 1, k, t.odometry[window.first_odometry + k - 1]);
  distance_m2 = heading_rad2 = 0.0;
  for (std::size_t k = a; k-- > 0;) extend(k + 1, k, t.odometry[window.first_odometry + k]);
  return path;
}

void thin_out(SearchProblem& problem) {
  constexpr std::size_t kMaxRanges = 80;
  const std::size_t n = problem.ranges.size();
  if (n <= kMaxRanges) return;
  for (std::size_t i = 0; i < kMaxRanges; ++i) problem.ranges[i] = problem.ranges[i * n / kMaxRanges];
  problem.ranges.resize(kMaxRanges);
  const std::pmr::vector<std::size_t> before(problem.group_first, scratch());
  const std::pmr::vector<double> bias_m(problem.group_bias_m, scratch());
  problem.group_first.clear();
  problem.group_bias_m.clear();
  for (std::size_t i = 0; i < kMaxRanges; ++i) {
    if (i > 0 && problem.ranges[i].beacon == problem.ranges[i - 1].beacon) continue;
    const auto group = std::ranges::upper_bound(before, i * n / kMaxRanges) - before.begin() - 1;
    problem.group_first.push_back(i);
    problem.group_bias_m.push_back(bias_m[static_cast<std::size_t>(group)]);
  }
  problem.group_first.push_back(kMaxRanges);
}

void lay_rigidly(Trajectory& t, const Segment& window, const Pose& T_map_anchor, const RigidPath& path) {
  for (std::size_t k = 0; k < path.T_anchor_node.size(); ++k) {
    t.nodes[window.first_node + k].T_map_vehicle = T_map_anchor * path.T_anchor_node[k];
    t.nodes[window.first_node + k].placed = true;
  }
}

std::size_t follow_odometry(Trajectory& t, const Segment& segment, std::size_t node, bool forward,
                            double span_s) {
  const double from_s = t.nodes[node].time_s;
  const auto step_before = [&](std::size_t k) -> const Pose& {
    return t.odometry[segment.first_odometry + k - 1 - segment.first_node].T_before_after;
  };
  while (forward ? node + 1 < segment.last_node : node > segment.first_node) {
    const std::size_t next = forward ? node + 1 : node - 1;
    t.nodes[next].T_map_vehicle =
        t.nodes[node].T_map_vehicle * (forward ? step_before(next) : step_before(node).inverse());
    t.nodes[next].placed = true;
    node = next;
    if (std::abs(t.nodes[node].time_s - from_s) >= span_s) break;
  }
  return node;
}

}  // namespace octant
