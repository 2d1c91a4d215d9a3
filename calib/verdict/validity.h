// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Where vehicles were, and how warm it was when something was heard.
struct LogExtent {
  std::vector<Eigen::Vector2d> places_m;
  double coldest_degC = INFINITY, hottest_degC = -INFINITY;
  /// @param run  the trajectory's
  void add(const Trajectory& trajectory, const MeasurementLog& run, const Site& site);
};

/// How far a beacon is heard, as a calibration shows it: where the vehicle stood farther from beacons so
/// often that it would have heard some of them twenty times, had it heard them as it does the nearer ones,
/// and heard next to nothing. A hall in which all is within reach tells nothing, and neither do few arrivals.
/// @param beacons  by BeaconId; undetermined ones are not looked at
/// @return distance within which all but half a percent of what was heard stood [m]
[[nodiscard]] std::optional<double> heard_reach_m(const std::vector<Trajectory>& trajectories,
                                                  const std::vector<DeploymentBeacon>& beacons);

}  // namespace octant::calib
