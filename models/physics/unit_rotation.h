// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Geometry>

namespace octant {

/// Normalises a quaternion read from a file or from another program. Deviations of a few digits from unit
/// length are left unchanged, so that written values read back identically. Returns no value if the length is
/// zero or not finite.
[[nodiscard]] inline std::optional<Eigen::Quaterniond> unit_rotation(double qx, double qy, double qz,
                                                                     double qw) {
  const Eigen::Quaterniond q(qw, qx, qy, qz);
  const double length = q.norm();
  if (!(length > 1e-3) || !std::isfinite(length)) return std::nullopt;
  return std::abs(length - 1.0) > 1e-14 ? q.normalized() : q;
}

}  // namespace octant
