// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/changes/reception.h"
#include "models/deployment.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Arrivals received from each beacon of the earlier deployment, and the numbers expected along the path of
/// the visit: within the reach in the deployment, and within the receivers' field of view.
[[nodiscard]] std::vector<Reception> receptions_of_beacons(const Deployment& before,
                                                           const std::vector<Trajectory>& trajectories);

/// Arrivals received by each receiver, and the numbers expected from the other receivers of its vehicle.
[[nodiscard]] std::vector<Reception> receptions_by_receivers(const Deployment& before,
                                                             const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
