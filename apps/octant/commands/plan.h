// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/octant/session.h"

namespace octant::app {

/// Arguments of `octant plan`. One of beacons, tolerance, stations and schedule selects the plan.
struct PlanArgs {
  std::string input, scene, vehicle, output, csv, report;
  std::vector<std::string> runs;
  // --beacons, --tolerance
  std::optional<int> beacons;
  std::optional<double> tolerance_m;
  int coverage = 0, most = 24, proof = 0;
  bool keep = false;
  std::string goal = "worst", algorithm = "crs2", local = "sbplx";
  int evaluations = 0, restarts = 6;
  double mount_sigma_m = 0.1;
  // --stations
  std::optional<int> stations;
  int headings = 8, rounds = 1;
  std::string criterion = "a";
  double clearance_m = 0.5;
  std::optional<double> grid_m, range_m, hearing_deg;
  // --schedule
  bool schedule = false, trust_walls = false, by_time = false;
  std::optional<double> height_m;
  double wall_reflection = 0.96, pulse_s = 2.5e-3;
};

// Each plan is defined in the file of the same name.
[[nodiscard]] int plan_beacons(const PlanArgs& args, Session& session);
[[nodiscard]] int plan_stations(const PlanArgs& args, Session& session);
[[nodiscard]] int plan_schedule(const PlanArgs& args, Session& session);

}  // namespace octant::app
