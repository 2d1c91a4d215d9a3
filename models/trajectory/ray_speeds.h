// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/physics/speed_profile.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Sets the speed of each arrival (ArrivalObservation::model_speed_mps) to that of its ray through a profile.
/// The ray runs between the beacon and the receiver as the state and the vehicle's poses have them. An error
/// of 1 m in height changes the speed by some 1e-5 of itself, so that repeating the adjustment with the new
/// speeds converges by a factor of about a hundred a round. Arrivals of vehicles without a pose keep theirs.
/// @return largest change of a predicted path length [m]
double set_ray_speeds(Trajectory& trajectory, const SharedState& state, const SpeedProfile& profile);

}  // namespace octant
