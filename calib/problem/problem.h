// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/contradiction.h"
#include "models/network/beacon_ranges.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Input of an adjustment: the priors of the site, and the recordings as trajectories of vehicle states with
/// their observations. A plain value, which later steps do not change.
struct Problem {
  Site site;
  std::vector<MeasurementLog> runs;
  BeaconRanges beacon_ranges;
  std::vector<Trajectory> trajectories;  ///< one for each run and vehicle that has arrivals or bearings
  std::vector<std::string> warnings;
  std::vector<Contradiction> contradictions;  ///< contradictions visible before an adjustment
  double typical_range_m = 1.0;               ///< median range of the arrivals by the site's priors
  /// Standard deviations of the receivers of each vehicle that are fixed nevertheless (0: they are not).
  std::vector<double> held_lever_sigma_m;
};

[[nodiscard]] inline double typical_range_m(const Problem& problem) { return problem.typical_range_m; }

/// Length that a deviation must not exceed: the site's tolerance for beacons, or a twentieth of the typical
/// range.
[[nodiscard]] inline double tolerance_m(const Problem& problem) {
  return problem.site.tolerance.beacon_m.value_or(0.05 * problem.typical_range_m);
}

/// The problem for an adjustment whose trajectories are elsewhere: without observations, with the same number
/// of runs (each may have its own offset of the speed), which are empty.
[[nodiscard]] Problem without_recordings(const Problem& problem);

/// Data of a site that its trajectories need.
[[nodiscard]] TrajectoryModel trajectory_model(const Site& site);

/// Widens the measured poses of a vehicle with fixed receivers by the sigma of these.
void widen_poses(const Problem& problem, Trajectory& trajectory);

/// Arrivals of a recording that no state carries, in words. @param line  of the first
[[nodiscard]] std::string stateless_in_words(const MeasurementLog& run, int line, std::size_t count);

/// Checks the recordings against the site and builds the trajectories.
/// Errors (kBadInput): no arrival at all; times of flight in the wrong unit (median distance beyond 20 times
/// the site's extent).
[[nodiscard]] Result<Problem> make_problem(Site site, std::vector<MeasurementLog> runs, int threads = 1);

}  // namespace octant::calib
