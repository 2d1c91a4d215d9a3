// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/run.h"

namespace octant {

/// Arrivals of a run as they would have come at the medium's one speed: each time of flight changed by the
/// difference between the straight path at that speed and the ray through the medium's profile. The vehicle
/// is where the fixes of the run have it. Without a fix of the epoch or within a second, an arrival is
/// changed for a vehicle at the sea surface, at the distance that its time of flight gives.
/// @param deployment  whose medium has a profile
[[nodiscard]] std::vector<Arrival> at_one_speed(std::span<const Arrival> arrivals, std::span<const Fix> fixes,
                                                const Deployment& deployment);

}  // namespace octant
