// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Geometry>

namespace octant {

/// The rotation that the four numbers of a quaternion write, whatever its length, as files and other programs
/// round them. Rounding in the last digits is left alone, so that what was written reads back the same. None:
/// no length, or no numbers.
[[nodiscard]] inline std::optional<Eigen::Quaterniond> unit_rotation(double qx, double qy, double qz,
                                                                     double qw) {
  const Eigen::Quaterniond q(qw, qx, qy, qz);
  const double length = q.norm();
  if (!(length > 1e-3) || !std::isfinite(length)) return std::nullopt;
  return std::abs(length - 1.0) > 1e-14 ? q.normalized() : q;
}

}  // namespace octant
