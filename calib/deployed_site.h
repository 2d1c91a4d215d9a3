// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/site.h"

namespace octant::calib {

/// Site of a deployment without priors: its beacons by name, its vehicles with their receivers, medium,
/// timing, noise and tolerance. The caller sets the priors.
[[nodiscard]] Site deployed_site(const Deployment& deployment);

}  // namespace octant::calib
