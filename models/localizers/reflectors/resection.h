// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "models/physics/plane.h"

namespace octant {

/// A planar pose as bearings fix it.
struct ResectedPose {
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d ahead = Eigen::Vector2d::UnitX();  ///< the vehicle's x axis on the map, a unit vector
  [[nodiscard]] double heading_rad() const { return angle_of(ahead); }
};

/// Where one stands on the circle that sees the first two of three points under an angle, and on that of the
/// last two: the intersection of both circles other than the second point (Smieszek, figure 2). Angles of 0
/// or pi, whose circle is a line, are no special case. Nothing on the danger circle, where all three points
/// and the observer lie on one circle, nor where points coincide.
/// @param turn12, turn23  cosine and sine of the angles from one point to the next, counter-clockwise
[[nodiscard]] std::optional<Eigen::Vector2d> intersect_sight_circles(
    const std::array<Eigen::Vector2d, 3>& p_map_m, const Eigen::Vector2d& turn12,
    const Eigen::Vector2d& turn23) noexcept;

/// Pose from the directions of three points. Nothing where the circles give none, or only one that would see
/// a point behind its bearing.
/// @param sight  unit vectors in the vehicle frame
[[nodiscard]] std::optional<ResectedPose> resect(const std::array<Eigen::Vector2d, 3>& p_map_m,
                                                 const std::array<Eigen::Vector2d, 3>& sight) noexcept;

}  // namespace octant
