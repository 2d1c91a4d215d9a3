// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// What the states of a run have to know of a deployment.
[[nodiscard]] TrajectoryModel trajectory_model(const Deployment& deployment);

}  // namespace octant
