// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/physics/pose.h"
#include "models/support/small_cholesky.h"

namespace octant {

/// Normal equations of a planar pose and its cycle offset: x, y, heading, offset [m].
struct PoseEquations {
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();  ///< lower triangle only
  Eigen::Vector4d g = Eigen::Vector4d::Zero();

  /// @param row  derivatives of the prediction; the last is used only if there is an offset
  void add(double w, const double (&row)[4], double residual, bool has_offset) {
    const double x = w * row[0], y = w * row[1], heading = w * row[2];
    g[0] += x * residual;
    g[1] += y * residual;
    g[2] += heading * residual;
    H(0, 0) += x * row[0];
    H(1, 0) += y * row[0];
    H(1, 1) += y * row[1];
    H(2, 0) += heading * row[0];
    H(2, 1) += heading * row[1];
    H(2, 2) += heading * row[2];
    if (!has_offset) return;
    const double offset = w * row[3];
    g[3] += offset * residual;
    for (int p = 0; p < 4; ++p) H(3, p) += offset * row[p];
  }

  /// Solves H step = g. Without information about the heading it stays unchanged. If all arrivals have lost
  /// their weight, a sigma of span_m keeps the position.
  /// @return not finite if H is not positive definite
  [[nodiscard]] Eigen::Vector4d step(double span_m, bool has_offset) const {
    Eigen::Matrix4d A = H;
    A(2, 2) += kVagueAngle;
    A.diagonal().head<2>().array() += 1.0 / (span_m * span_m);
    A(3, 3) += 1e-12;
    return has_offset ? solved<4>(A) : solved<3>(A);
  }

 private:
  /// Solves for the first N unknowns.
  template <int N>
  [[nodiscard]] Eigen::Vector4d solved(const Eigen::Matrix4d& A) const {
    Eigen::Vector4d b = g;
    SmallCholesky<N> factor;
    static_cast<void>(factor.factor(A));
    factor.forward(b);
    factor.backward(b);
    return b;
  }
};

}  // namespace octant
