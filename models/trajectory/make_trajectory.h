// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/trajectory/trajectory.h"

namespace octant {

/// Builds the states of one vehicle of a run and attaches its observations.
/// Epochs: one node each (chained by odometry where the run has it); measured poses interpolated at the
/// epoch's arrivals. No epochs, odometry: nodes at its rows; arrivals and measured poses between them. No
/// epochs, no odometry, no poses, but a motion prior: a node with a velocity for each instant of arrivals,
/// tied by the prior. Else: one node for each distinct arrival time, with the measured pose of that time if
/// there is one.
[[nodiscard]] Trajectory make_trajectory(const MeasurementLog& log, std::size_t run, VehicleId vehicle,
                                         const TrajectoryModel& model);

}  // namespace octant
