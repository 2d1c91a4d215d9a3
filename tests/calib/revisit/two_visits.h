// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Two visits to one simulated hall.

#include <functional>
#include <vector>

#include "calib/revisit/finished.h"
#include "calib/revisit/revisit.h"
#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"

namespace octant::calib {

using test::beacon;
using test::must;

inline constexpr std::size_t kControlPoint = 3, kFree = 4;

/// Eight beacons, four receivers half a metre apart, 60 stops, temperature known.
inline Scenario first_scenario() {
  Scenario s = test::hall_scenario();
  s.site.vehicles.clear();
  s.site.receivers.clear();
  test::add_receivers(s.site, {{0.4, 0.0, 0.3}, {0.0, 0.4, 0.45}, {-0.4, 0.0, 0.3}, {0.0, -0.4, 0.45}},
                      0.001);
  s.true_temperature_offset_degC.reset();
  s.true_speed_offset_mps = 0.5;
  s.true_delay_s = {1e-4, 1e-4};
  s.path.epochs = 60;
  return s;
}

/// The deployment of a first visit, and a second visit of 20 stops to a world that was changed in between.
struct TwoVisits {
  Deployment before;
  MeasurementLog second;
};

TwoVisits two_visits(const std::function<void(Scenario&)>& change, int epochs = 20,
                     Scenario scenario = first_scenario()) {
  const World first = must(simulate(scenario, 11));
  Problem problem = must(make_problem(first.site, {first.run}));
  const Solution solution = solve(problem);
  EXPECT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  TwoVisits out;
  out.before = make_deployment(problem, solution, {"2026-01-01T00:00:00Z", "", "", {}});
  out.before.digest = "first";
  // Keeps receivers and air of the first visit, which the simulator otherwise draws for each seed.
  if (scenario.site.attenuation) {
    const AttenuationModel& air = *first.truth.attenuation;
    scenario.site.attenuation->amplitude_1m_v = {air.amplitude_1m_v, 0.0};
    scenario.site.attenuation->absorption_np_per_m = {air.absorption_np_per_m, 0.0};
    scenario.site.attenuation->rise_time_s = {air.rise_time_s, 0.0};
  }
  for (std::size_t r = 0; r < scenario.site.receivers.size(); ++r) {
    scenario.site.receivers[r].position_m = first.truth.receivers[r].position_m;
    scenario.site.receivers[r].sigma_m.setZero();
  }
  change(scenario);
  scenario.path.epochs = epochs;
  out.second = must(simulate(scenario, 12)).run;
  return out;
}

inline Revisit revisited(const TwoVisits& visits) {
  const Revisit found = must(revisit(visits.before, {visits.second}, {}));
  EXPECT_EQ(found.status, SolveStatus::kConverged) << found.message;
  return found;
}

inline void move(Scenario& s, std::size_t b, const Eigen::Vector3d& by_m) {
  for (std::size_t i = 0; i < 3; ++i) *s.site.beacons[b].position_m[i] += by_m[static_cast<Eigen::Index>(i)];
}

}  // namespace octant::calib
