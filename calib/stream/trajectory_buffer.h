// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/sums/log_buffer.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Writes a trajectory with its states and the rows of its arrivals.
/// @param rows  rows of the run in memory, to which ArrivalObservation::arrival refers
void write_trajectory(const Trajectory& trajectory, const std::vector<Arrival>& rows, BufferWriter& buffer);

/// Reads one and appends it to a trajectory and the rows.
/// @param model  of the site
void read_trajectory(const TrajectoryModel& model, BufferReader& buffer, Trajectory& to,
                     std::vector<Arrival>& rows);

}  // namespace octant::calib
