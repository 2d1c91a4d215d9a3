// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/localizers/common/separation.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Errors that the arrivals of a fault-free beacon may have in common. They explain a part of its misfit.
struct BeaconErrors {
  /// Calibration covariance of each beacon's x, y, z [m], delay [s] and the speed [m/s]. Empty: exact.
  std::span<const Eigen::Matrix<double, 5, 5>> calibration;
  /// Sigma of errors that persist over several arrivals (noise.correlated). It is specified for a pair of
  /// beacon and receiver, but the errors arise along the path, which neighbouring receivers share.
  double common_sigma_s = 0.0;
};

/// Separation of each beacon in use, at the state of the segment's node.
[[nodiscard]] std::pmr::vector<BeaconSeparation> separations(const Trajectory& trajectory,
                                                             const Segment& segment, const SharedState& state,
                                                             const BeaconErrors& errors);

/// Protection level, and the faulty beacon if there is one: its misfit exceeds the chi-square quantile that
/// corresponds to six sigmas, a probability of 1e-9.
/// @param covariance  covariance of the fix including the calibration. The fix without a beacon is inflated
/// by the ratio of this covariance to that of the noise.
[[nodiscard]] Protection protection_of(const Trajectory& trajectory, const Segment& segment,
                                       const SharedState& state, const PoseCovariance& covariance,
                                       const BeaconErrors& errors);

}  // namespace octant
