// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "models/physics/plane.h"

namespace octant {

/// Planar pose from bearings.
struct ResectedPose {
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d ahead = Eigen::Vector2d::UnitX();  ///< the vehicle's x axis on the map, a unit vector
  [[nodiscard]] double heading_rad() const { return angle_of(ahead); }
};

/// Intersects the circle of points that see the first two of three points at an angle with the circle for the
/// last two, other than in the second point (Smieszek, figure 2). Angles of 0 or pi, whose circle is a line,
/// need no special treatment. No value on the danger circle, where the observer and all three points lie on
/// one circle, or if points coincide.
/// @param turn12, turn23  cosine and sine of the angles from one point to the next, counter-clockwise
[[nodiscard]] std::optional<Eigen::Vector2d> intersect_sight_circles(
    const std::array<Eigen::Vector2d, 3>& p_map_m, const Eigen::Vector2d& turn12,
    const Eigen::Vector2d& turn23) noexcept;

/// Pose from the directions of three points. No value if the circles have no intersection, or if it would see
/// a point in the opposite direction.
/// @param sight  unit vectors in the vehicle frame
[[nodiscard]] std::optional<ResectedPose> resect(const std::array<Eigen::Vector2d, 3>& p_map_m,
                                                 const std::array<Eigen::Vector2d, 3>& sight) noexcept;

}  // namespace octant
