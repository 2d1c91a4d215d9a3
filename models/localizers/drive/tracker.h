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

/// Initial states of a moving trajectory with odometry: stretches are placed as rigid pieces of the odometry
/// path by a search over poses, joined, and solved robustly. Without odometry, but with a motion prior: by
/// short windows (motion_start.h). Sets nodes and marks arrivals. Returns false when no stretch could be
/// placed.
[[nodiscard]] bool place_drive(Trajectory& trajectory, const EpochFixModel& model,
                               const TrackerOptions& options = {});

/// Tracker of a moving vehicle: odometry predicts, arrivals correct one by one, robustly.
/// One fix at every distinct arrival time; smoothed over the whole run unless options.smooth is off. A drive
/// with a motion prior instead of odometry is always smoothed. Stops with odometry between them are smoothed
/// the same way, a fix an epoch; those that it does not tie together are fixed one by one. In space odometry
/// of six degrees of freedom tells the attitude as well; where the path leaves that open, the place follows
/// from the arrivals alone, smoothed (space_track.h). A fix's covariance
/// holds the calibration's part, which does not average out along the drive (chain_calibration.h).
[[nodiscard]] std::vector<Fix> track(const MeasurementLog& all_rows, const Deployment& deployment,
                                     const TrackerOptions& options = {});

}  // namespace octant
