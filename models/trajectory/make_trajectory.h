// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/trajectory/trajectory.h"

namespace octant {

/// Builds the states of one vehicle in a run and attaches its observations. The log decides about the states:
/// - Epochs: one node for each epoch, linked by odometry if the run has it. Measured poses are interpolated
/// at the epoch's arrivals.
/// - Odometry without epochs: one node for each row. Arrivals and measured poses lie between nodes.
/// - Neither of them nor poses, but a motion prior: one node with a velocity for each instant of arrivals,
/// linked by the prior.
/// - Otherwise: one node for each distinct arrival time, with the measured pose of that time if there is one.
[[nodiscard]] Trajectory make_trajectory(const MeasurementLog& log, std::size_t run, VehicleId vehicle,
                                         const TrajectoryModel& model);

}  // namespace octant
