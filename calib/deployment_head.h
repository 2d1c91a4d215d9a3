// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/calibrate.h"

namespace octant::calib {

/// What a deployment takes over from the site and from where it came, whatever the outcome: all but what was
/// solved for.
[[nodiscard]] Deployment deployment_head(const Site& site, const Solution& solution,
                                         const Provenance& provenance);

}  // namespace octant::calib
