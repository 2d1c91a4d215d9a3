// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Initial states of a moving trajectory. With odometry, parts are placed as rigid pieces of the path by a
/// search over poses, joined, and solved robustly. Without odometry but with a motion prior, short windows
/// are used (motion_start.h). Sets nodes and marks arrivals. Returns false if no part could be placed.
[[nodiscard]] bool place_drive(Trajectory& trajectory, const EpochFixModel& model,
                               const TrackerOptions& options = {});

/// Tracks a moving vehicle: odometry predicts, and arrivals correct one by one, robustly. There is one fix at
/// every distinct arrival time, smoothed over the whole run unless options.smooth is off. A drive with a
/// motion prior instead of odometry is always smoothed. Stops linked by odometry are smoothed the same way,
/// with one fix for each epoch; others are fixed one by one. Odometry with six degrees of freedom also
/// determines the attitude in space. If the path leaves the attitude open, the position follows from the
/// arrivals alone, smoothed (space_track.h). The covariance of a fix includes the calibration, which does not
/// average out along the drive (chain_calibration.h).
[[nodiscard]] std::vector<Fix> track(const MeasurementLog& all_rows, const Deployment& deployment,
                                     const TrackerOptions& options = {});

}  // namespace octant
