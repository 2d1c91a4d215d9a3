// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>

#include "models/localizers/least_squares/search_problem.h"
#include "models/physics/pose.h"

namespace octant::test {

/// Input of the search if each receiver receives each beacon, beacon by beacon, without noise.
/// @param levers  receivers in the vehicle's frame [m]
/// @param sigma_m  sigma of a range
inline SearchProblem search_problem_at(const PlanarState& truth, std::span<const Eigen::Vector3d> beacons,
                                       std::span<const Eigen::Vector3d> levers, double sigma_m) {
  SearchProblem problem;
  const Pose T = Pose::planar(truth.x_m, truth.y_m, truth.heading_rad);
  for (std::size_t b = 0; b < beacons.size(); ++b) {
    problem.group_first.push_back(problem.ranges.size());
    problem.group_bias_m.push_back(0.0);
    for (const Eigen::Vector3d& lever : levers) {
      SearchRange r;
      r.p_beacon_map_m = beacons[b];
      r.p_lever_m = lever;
      r.range_m = (T * r.p_lever_m - beacons[b]).norm();
      r.sigma_m = sigma_m;
      r.beacon = BeaconId(b);
      r.observation = problem.ranges.size();
      problem.ranges.push_back(r);
      problem.span_m = std::max(problem.span_m, r.range_m);
      problem.lever_m = std::max(problem.lever_m, lever.head<2>().norm());
    }
  }
  problem.group_first.push_back(problem.ranges.size());
  problem.median_sigma_m = sigma_m;
  return problem;
}

}  // namespace octant::test
