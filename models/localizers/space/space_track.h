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

/// Returns true if the arrivals of a run can be tracked in space: there is neither odometry nor a motion
/// prior, and the clocks are synchronised.
[[nodiscard]] bool may_track_in_space(const Deployment& deployment, const MeasurementLog& log);

/// Returns true if a run is a drive in space that is best located by its arrivals alone: it can be, and at
/// one time there are too few arrivals or receivers for a pose with six degrees of freedom. Epochs count as
/// times if most of them follow each other within SpaceTrackOptions::max_gap_s; stops that are further apart
/// are located one by one.
[[nodiscard]] bool is_drive_in_space(const Deployment& deployment, const MeasurementLog& log);

/// Track of a vehicle in space by its arrivals alone: position and velocity under white-noise acceleration,
/// with the spectral density that maximises the likelihood of the innovations. An iterated extended Kalman
/// filter, smoothed over the run (Rauch, Tung and Striebel 1965).
///
/// The attitude is not estimated. The rotation of a fix is the identity with the variance of a uniform angle,
/// and the effect of the receivers' lever arms on the origin is part of its covariance. The velocity is along
/// the axes of the map, and the turn rate is unknown (the variance of a uniform angle, per second). Lasting
/// errors (noise.correlated) are a first-order Gauss-Markov state for each beacon. The calibration's part of
/// the covariance follows the estimate through filter and smoother (Schmidt's consider parameters). There is
/// one fix at every time with arrivals (an epoch, or a ping). Times without a track are located one by one if
/// they have enough arrivals (LeastSquaresLocalizer).
///
/// For coplanar beacons there is a mirror image. The position nearer to the calibrated poses is used. If that
/// does not decide, the one above the floor (z = 0) is used and, if both are, the one below the beacons. A
/// track near their plane may have passed through it, and an image within the calibrated space is possible:
/// then the distance of the images is part of the covariance.
///
/// Protection levels are horizontal. There is no level if fewer than four beacons are received, if the track
/// is lost without one of them, or if it deviates by six sigmas from such a track.
[[nodiscard]] std::vector<Fix> track_in_space(const MeasurementLog& log, const Deployment& deployment,
                                              const SpaceTrackOptions& options = {});

}  // namespace octant
