// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace octant {

/// A planar pose as bearings fix it.
struct ResectedPose {
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
};

/// Where the second point of three lies on the circle through the first two, and on that through the last
/// two, under the angles from one to the next (counter-clockwise, any branch): the intersection of both
/// circles other than the second point (Smieszek, figure 2). Angles of 0 or pi, whose circle is a line, are
/// no special case. Nothing on the danger circle, where all three points and the observer lie on one circle,
/// nor where points coincide.
[[nodiscard]] std::optional<Eigen::Vector2d> intersect_sight_circles(
    const std::array<Eigen::Vector2d, 3>& p_map_m, double angle12_rad, double angle23_rad) noexcept;

/// Pose from bearings to three points, counter-clockwise from the vehicle's x axis. Nothing where the circles
/// give none, or only one that would see a point behind its bearing.
[[nodiscard]] std::optional<ResectedPose> resect(const std::array<Eigen::Vector2d, 3>& p_map_m,
                                                 const std::array<double, 3>& bearing_rad) noexcept;

}  // namespace octant
