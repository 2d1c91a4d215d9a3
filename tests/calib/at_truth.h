// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <vector>

#include "calib/problem/problem.h"
#include "models/trajectory/shared_state.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// A simulated world as a calibration problem, with its states at the true poses.
struct AtTruth {
  World world;
  calib::Problem problem;
  SharedState state;
  std::vector<Trajectory> trajectories;

  AtTruth(const Scenario& scenario, std::uint64_t seed)
      : world(must(simulate(scenario, seed))),
        problem(must(calib::make_problem(world.site, {world.run}))),
        state(shared_state(world.truth)),
        trajectories(problem.trajectories) {
    for (Trajectory& t : trajectories)
      for (Node& node : t.nodes) {
        if (!interpolate_poses(world.run.truth, node.time_s, 10.0, node.T_map_vehicle))
          throw std::runtime_error("a state outside the truth");
        node.placed = true;
      }
  }
};

}  // namespace octant::test
