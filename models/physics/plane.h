// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace octant {

/// A vector of the plane turned by a quarter counter-clockwise.
[[nodiscard]] inline Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// z component of the cross product: positive where b lies to the left of a.
[[nodiscard]] inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Cosine and sine of the angle from a to b, times the lengths of both.
[[nodiscard]] inline Eigen::Vector2d turn_between(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {a.dot(b), cross(a, b)};
}

/// From the x axis, counter-clockwise, in (-pi, pi].
[[nodiscard]] inline double angle_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

[[nodiscard]] inline double square(double x) { return x * x; }

}  // namespace octant
