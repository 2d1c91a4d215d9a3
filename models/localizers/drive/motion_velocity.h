// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/fix.h"

namespace octant {

/// Velocity with the components of a motion: 3 in the plane (along x, y, about z), 6 in space.
template <int kDof>
using MotionVelocity = Eigen::Matrix<double, kDof, 1>;

template <int kDof>
[[nodiscard]] MotionVelocity<kDof> in_motion(const Velocity& v) {
  if constexpr (kDof == 6) {
    return v;
  } else {
    return {v[0], v[1], v[5]};
  }
}

template <int kDof>
[[nodiscard]] Velocity in_space(const MotionVelocity<kDof>& v) {
  if constexpr (kDof == 6) {
    return v;
  } else {
    return (Velocity() << v[0], v[1], 0.0, 0.0, 0.0, v[2]).finished();
  }
}

/// Vector with one value along the axes and another one about them.
template <int kDof>
[[nodiscard]] MotionVelocity<kDof> along_and_about(double along, double about) {
  constexpr int kPlaces = kDof == 3 ? 2 : 3;
  MotionVelocity<kDof> all;
  all.template head<kPlaces>().setConstant(along);
  all.template tail<kDof - kPlaces>().setConstant(about);
  return all;
}

}  // namespace octant
