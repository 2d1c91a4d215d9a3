// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace octant {

/// Vector rotated counter-clockwise by a right angle.
[[nodiscard]] inline Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// z component of the cross product: positive where b lies to the left of a.
[[nodiscard]] inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Cosine and sine of the angle from a to b, times the lengths of both.
[[nodiscard]] inline Eigen::Vector2d turn_between(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {a.dot(b), cross(a, b)};
}

/// Unit vector at an angle from the x axis.
[[nodiscard]] inline Eigen::Vector2d direction_of(double angle_rad) {
  return {std::cos(angle_rad), std::sin(angle_rad)};
}

/// Angle from the x axis, counter-clockwise, in (-pi, pi].
[[nodiscard]] inline double angle_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

/// Distance of a point from a line segment, which may have length zero.
[[nodiscard]] inline double distance_from_segment(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                                  const Eigen::Vector2d& point) {
  const Eigen::Vector2d along = to - from;
  const double squared = along.squaredNorm();
  const double share = squared > 0.0 ? std::clamp((point - from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (point - from - share * along).norm();
}

[[nodiscard]] inline double square(double x) { return x * x; }

/// Larger eigenvalue of the symmetric matrix [xx xy; xy yy].
[[nodiscard]] inline double largest_eigenvalue(double xx, double xy, double yy) {
  return 0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy);
}

}  // namespace octant
