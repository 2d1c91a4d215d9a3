// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/contradiction.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// What is to be adjusted: the site's prior knowledge and the recordings, turned into trajectories of vehicle
/// states with their observations. A plain value; nobody downstream changes it.
struct Problem {
  Site site;
  std::vector<MeasurementLog> runs;
  std::vector<Trajectory> trajectories;  ///< one for each run and vehicle that has arrivals or bearings
  std::vector<std::string> warnings;
  std::vector<Contradiction> contradictions;  ///< that show before any adjustment
  double typical_range_m = 1.0;               ///< median range of the arrivals by the site's priors
  /// By how much the receivers of each vehicle may be off where they are held all the same (0: they are
  /// not).
  std::vector<double> held_lever_sigma_m;
};

[[nodiscard]] inline double typical_range_m(const Problem& problem) { return problem.typical_range_m; }

/// Length that a deviation must not exceed: the site's tolerance for beacons, or a twentieth of the typical
/// range.
[[nodiscard]] inline double tolerance_m(const Problem& problem) {
  return problem.site.tolerance.beacon_m.value_or(0.05 * problem.typical_range_m);
}

/// The problem as an adjustment sees it whose trajectories are elsewhere: without observations, with as many
/// runs (each may have its own offset of the speed), which are empty.
[[nodiscard]] Problem without_recordings(const Problem& problem);

/// What the trajectories of a site need to know of it.
[[nodiscard]] TrajectoryModel trajectory_model(const Site& site);

/// Measured poses of a vehicle whose receivers are held are off by the sigma of these as well.
void widen_poses(const Problem& problem, Trajectory& trajectory);

/// Arrivals of a recording that no state carries, in words. @param line  of the first
[[nodiscard]] std::string stateless_in_words(const MeasurementLog& run, int line, std::size_t count);

/// Checks the recordings against the site and builds the trajectories.
/// Errors (kBadInput): no arrival at all; times of flight in the wrong unit (median distance beyond 20 times
/// the site's extent).
[[nodiscard]] Result<Problem> make_problem(Site site, std::vector<MeasurementLog> runs, int threads = 1);

}  // namespace octant::calib
