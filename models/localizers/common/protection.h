// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/localizers/common/separation.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// What the arrivals of a beacon may be off together without a fault: a misfit may have that of its own.
struct BeaconErrors {
  /// What the calibration of each beacon may be off: x, y, z [m], delay [s] and the speed [m/s]. Empty: it is
  /// exact.
  std::span<const Eigen::Matrix<double, 5, 5>> calibration;
  /// Sigma of errors that last beyond an arrival (noise.correlated). They are stated for a pair of beacon and
  /// receiver, but come from the path, and receivers side by side share that.
  double common_sigma_s = 0.0;
};

/// Separation of each beacon in use, at the state that the segment's node holds.
[[nodiscard]] std::pmr::vector<BeaconSeparation> separations(const Trajectory& trajectory,
                                                             const Segment& segment, const SharedState& state,
                                                             const BeaconErrors& errors);

/// The level and whether a beacon is at fault: its misfit is beyond the chi-square quantile of six sigmas, a
/// chance of 1e-9.
/// @param covariance  of the fix, calibration's part included: by as much as that widens the noise's, the fix
/// without a beacon is widened too
[[nodiscard]] Protection protection_of(const Trajectory& trajectory, const Segment& segment,
                                       const SharedState& state, const PoseCovariance& covariance,
                                       const BeaconErrors& errors);

}  // namespace octant
