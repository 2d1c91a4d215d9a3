// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/physics/speed_profile.h"
#include "models/run.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Sets the speed of each arrival (ArrivalObservation::model_speed_mps) to that of its ray through a profile.
/// The ray runs between the beacon and the receiver as the state and the vehicle's poses have them. An error
/// of 1 m in height changes the speed by some 1e-5 of itself, so that repeating the adjustment with the new
/// speeds converges by a factor of about a hundred a round. Arrivals of vehicles without a pose keep theirs.
/// @return largest change of a predicted path length [m]
double set_ray_speeds(Trajectory& trajectory, const SharedState& state, const SpeedProfile& profile);

/// Arrivals of a run as they would have come at the medium's one speed: each time of flight changed by the
/// difference between the straight path at that speed and the ray through the medium's profile. The vehicle
/// is where the fixes of the run have it. Arrivals without a fix of their epoch or within a second of it stay
/// as they are.
/// @param deployment  whose medium has a profile
[[nodiscard]] std::vector<Arrival> at_one_speed(std::span<const Arrival> arrivals, std::span<const Fix> fixes,
                                                const Deployment& deployment);

}  // namespace octant
