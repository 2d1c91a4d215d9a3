// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/odometry_track.h"

#include <cmath>

#include "models/physics/plane.h"
#include "models/trajectory/odometry_noise.h"

namespace octant {

Eigen::Matrix3d advance(OdometryState& state, const OdometryStep& step, const OdometryAccuracy& accuracy,
                        double fraction) {
  const Eigen::Vector2d move =
      Eigen::Rotation2Dd(state.heading_rad) * Eigen::Vector2d(fraction * step.dx_m, fraction * step.dy_m);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F.topRightCorner<2, 1>() = left_of(move);
  const OdometryVariance variance = variance_of(step, accuracy);
  state.covariance = F * state.covariance * F.transpose();
  state.covariance.diagonal() +=
      fraction * Eigen::Vector3d(variance.distance_m2, variance.distance_m2, variance.heading_rad2);
  state.p_map_m += move;
  state.heading_rad = wrap_angle(state.heading_rad + fraction * step.dheading_rad);
  return F;
}

}  // namespace octant
