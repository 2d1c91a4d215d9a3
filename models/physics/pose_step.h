// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/physics/plane.h"
#include "models/physics/pose.h"

namespace octant {

/// Derivative of the pose after a step by the pose before it. In space a turn dphi in the vehicle's frame
/// moves the end of the step by -R [s]x dphi, and is a turn Rs' dphi in the frame after the step.
template <int kDof>
Eigen::Matrix<double, kDof, kDof> by_step(const Pose& T, const Pose& step) {
  Eigen::Matrix<double, kDof, kDof> F = Eigen::Matrix<double, kDof, kDof>::Identity();
  if constexpr (kDof == 3) {
    F.template topRightCorner<2, 1>() =
        left_of(Eigen::Rotation2Dd(T.heading_rad()) * step.translation_m.template head<2>());
  } else {
    F.template topRightCorner<3, 3>() = -T.rotation.toRotationMatrix() * skew(step.translation_m);
    F.template bottomRightCorner<3, 3>() = step.rotation.toRotationMatrix().transpose();
  }
  return F;
}

/// Step of a vehicle with constant velocity.
template <class Vector>
Pose step_at(const Vector& velocity, double span_s) {
  if constexpr (Vector::RowsAtCompileTime == 3) {
    return Pose::planar(velocity[0] * span_s, velocity[1] * span_s, velocity[2] * span_s);
  } else {
    return {velocity.template head<3>() * span_s, exp_rotation(velocity.template tail<3>() * span_s)};
  }
}

}  // namespace octant
