// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/rows_by_pose.h"
#include "models/localizers/space/space_track_options.h"
#include "models/run.h"

namespace octant {

/// Whether the arrivals of a run can be tracked in space: there is neither odometry nor a motion prior, and
/// the clocks are synchronised.
[[nodiscard]] bool may_track_in_space(const Deployment& deployment, const MeasurementLog& log);

/// Whether a run is a drive in space that is best located by its arrivals alone: it can be, and at
/// an instant has too few arrivals or receivers for a pose of six degrees of freedom. Epochs may be its
/// instants where most of them follow each other within SpaceTrackOptions::max_gap_s; stops that are further
/// apart in time are located one by one.
[[nodiscard]] bool is_drive_in_space(const Deployment& deployment, const MeasurementLog& log);

/// Track of a vehicle in space by its arrivals alone: position and velocity under white-noise acceleration,
/// whose density is that of the greatest likelihood of the innovations. An iterated extended Kalman filter,
/// smoothed over the run (Rauch, Tung and Striebel 1965). The attitude is not estimated: the fix's rotation
/// is the identity with the variance of a uniform angle, and what the receivers' lever arms may put the
/// origin off counts in its covariance. Errors that last (noise.correlated) are a first-order Gauss-Markov
/// state a beacon; the calibration's part of the covariance follows the estimate through filter and smoother
/// (Schmidt's consider parameters). One fix at every instant of arrivals (an epoch, or a ping). Instants that
/// no track reaches are located one by one where they have arrivals enough (LeastSquaresLocalizer).
///
/// Beacons in one plane leave a mirror image: taken is the one above the floor (z = 0) and, if both are,
/// below the beacons. A track that comes near their plane may have gone through it: then the distance of the
/// images counts in the covariance.
///
/// Protection levels are horizontal, as everywhere. None where fewer than four beacons are heard, where the
/// track is lost without one of them, or lies six sigmas off it.
[[nodiscard]] std::vector<Fix> track_in_space(const MeasurementLog& log, const Deployment& deployment,
                                              const SpaceTrackOptions& options = {});

}  // namespace octant
