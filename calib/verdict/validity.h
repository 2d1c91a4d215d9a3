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

/// Positions of the vehicles and range of temperatures at the arrivals.
struct LogExtent {
  std::vector<Eigen::Vector2d> places_m;
  double coldest_degC = INFINITY, hottest_degC = -INFINITY;
  /// @param run  recording of the trajectory
  void add(const Trajectory& trajectory, const MeasurementLog& run, const Site& site);
};

/// Range within which beacons are received, by the recordings of a calibration. The vehicle must have been
/// farther away so often that, with the reception of nearer beacons, at least twenty receptions would be
/// expected, and must have received hardly any. Otherwise no value: a hall within reach of all beacons, or
/// few arrivals, do not determine a range.
/// @param beacons  by BeaconId; undetermined ones are ignored
/// @return distance within which 99.5 % of the received arrivals were [m]
[[nodiscard]] std::optional<double> heard_reach_m(const std::vector<Trajectory>& trajectories,
                                                  const std::vector<DeploymentBeacon>& beacons);

}  // namespace octant::calib
