// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "calib/readings/explain.h"
#include "tests/calib/calib_support.h"

namespace octant::test {

/// With the false statement behind it looked for, as `octant calibrate` does.
inline calib::Solution explained_solution(const World& world) {
  const calib::Problem problem = problem_of(world);
  // The findings must not depend on the speed of the machine.
  const calib::SolveOptions all = {.diagnosis_s = INFINITY};
  calib::Solution solution = calib::solve(problem, all);
  calib::explain(problem, problem, solution, all);
  return solution;
}
inline std::vector<Contradiction> explained(const World& world) {
  return explained_solution(world).contradictions;
}

/// A hall where a cart with four receivers, no square, stops.
inline World cart(int epochs = 40, std::uint64_t seed = 1, double echoes = 0.03) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  s.echo_fraction = echoes;
  const Eigen::Vector3d places[4] = {
      {0.35, 0.2, 0.3}, {0.35, -0.2, 0.3}, {-0.35, 0.2, 0.45}, {-0.35, -0.2, 0.45}};
  const char* names[4] = {"fl", "fr", "rl", "rr"};
  s.site.receivers.clear();
  for (int i = 0; i < 4; ++i)
    s.site.receivers.push_back({names[i], VehicleId(0), places[i], Eigen::Vector3d::Constant(0.001), {}});
  s.site.vehicles[0].first_receiver = 0;
  s.site.vehicles[0].receiver_count = 4;
  s.site.vehicles[0].array.reset();
  return must(simulate(s, seed));
}

/// Times of flight from a share of the log on are longer by jump_s. @return the first time after the jump
inline double jump_clock(World& world, double share, double jump_s) {
  const auto n = static_cast<double>(world.run.arrivals.size());
  const std::int64_t epoch = world.run.arrivals[static_cast<std::size_t>(share * n)].epoch;
  double first_after_s = INFINITY;
  for (Arrival& a : world.run.arrivals) {
    if (a.epoch < epoch) continue;
    first_after_s = std::min(first_after_s, a.time_s);
    a.tof_s += jump_s;
  }
  return first_after_s;
}

/// A jump along a drive. @return the first time after the jump
inline double jump_clock_of_drive(World& world, double share, double jump_s) {
  std::vector<Arrival>& arrivals = world.run.arrivals;
  const double at_s = arrivals[static_cast<std::size_t>(share * static_cast<double>(arrivals.size()))].time_s;
  for (Arrival& a : arrivals) a.tof_s += a.time_s >= at_s ? jump_s : 0.0;
  return at_s;
}

}  // namespace octant::test
