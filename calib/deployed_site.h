// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/site.h"

namespace octant::calib {

/// The site that a deployment describes, without priors: its beacons by name, its vehicles with their
/// receivers, medium, timing, noise and tolerance. What the deployment knows of the parameters is for the
/// caller to state.
[[nodiscard]] Site deployed_site(const Deployment& deployment);

}  // namespace octant::calib
