// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/problem/log_totals.h"
#include "models/deployment.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Extent of the solved poses of a trajectory and of its arrivals. @param run  its recording
[[nodiscard]] LogExtent extent_of(const Trajectory& trajectory, const MeasurementLog& run, const Site& site);

/// Replaces the area, and in space the heights, for which a deployment is valid.
void set_valid_space(LogExtent extent, Deployment& deployment);

/// Range within which beacons are received, by the recordings of a calibration. The vehicle must have been
/// farther away so often that, with the reception of nearer beacons, at least twenty receptions would be
/// expected, and must have received hardly any. Otherwise no value: a hall within reach of all beacons, or
/// few arrivals, do not determine a range.
/// @param beacons  by BeaconId; undetermined ones are ignored
/// @return distance within which 99.5 % of the received arrivals were [m]
[[nodiscard]] std::optional<double> heard_reach_m(const std::vector<Trajectory>& trajectories,
                                                  const std::vector<DeploymentBeacon>& beacons);

}  // namespace octant::calib
