// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/fix.h"

namespace octant {

/// A fix in space whose attitude was not estimated locates one point of the vehicle, the centre of its
/// receivers: its translation is that of the centre, its rotation the identity. Its covariance is the
/// origin's: it counts the origin anywhere on the sphere about the centre.
[[nodiscard]] inline bool has_open_attitude(const Fix& fix) {
  return fix.covariance.rows() == 6 &&
         fix.covariance.diagonal().tail<3>().minCoeff() >= 0.99 * kUnknownRotationVariance;
}

/// Variance along each axis of a point at a distance from the origin, every direction being equally likely
/// [m^2].
[[nodiscard]] inline double open_attitude_variance_m2(const Eigen::Vector3d& p_vehicle_m) {
  return p_vehicle_m.squaredNorm() / 3;
}

/// Centre of a vehicle's receivers; the origin where it has none.
[[nodiscard]] inline Eigen::Vector3d receiver_centre_m(const Deployment& deployment, VehicleId vehicle) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const DeploymentReceiver& r : deployment.receivers)
    if (r.vehicle == vehicle) {
      sum += r.position_m;
      count += 1.0;
    }
  return count > 0.0 ? Eigen::Vector3d(sum / count) : sum;
}

}  // namespace octant
