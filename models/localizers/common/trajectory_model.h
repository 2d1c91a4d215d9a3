// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Properties of a deployment that the states of a run depend on.
[[nodiscard]] TrajectoryModel trajectory_model(const Deployment& deployment);

}  // namespace octant
