// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/problem.h"
#include "calib/revisit/revisit.h"
#include "models/deployment.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// The thermometer of the recordings: whether each arrival has a temperature, and their mean.
[[nodiscard]] MediumFound thermometer_of(const Deployment& deployment,
                                         const std::vector<MeasurementLog>& runs);

/// What a deployment is valid for, by a visit's places and (where they are known) its temperatures too.
void extend_validity(Deployment& deployment, const std::vector<Trajectory>& trajectories,
                     const Problem& problem, bool temperature_known);

}  // namespace octant::calib
