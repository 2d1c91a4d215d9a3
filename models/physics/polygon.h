// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace octant {

using Polygon = std::vector<Eigen::Vector2d>;  ///< corners in order, the last joins the first

/// The least upright rectangle that holds all points; empty where there is none.
[[nodiscard]] Eigen::AlignedBox2d bounds_of(std::span<const Eigen::Vector2d> points);

/// Twice the signed area is positive where the corners go counter-clockwise.
[[nodiscard]] double signed_area_m2(const Polygon& polygon);
/// By even and odd crossings; on the outline either.
[[nodiscard]] bool is_inside(const Polygon& polygon, const Eigen::Vector2d& point);
/// Of the outline. @param polygon  not empty
[[nodiscard]] Eigen::Vector2d nearest_on_outline(const Polygon& polygon, const Eigen::Vector2d& point);
/// To the outline, within or without.
[[nodiscard]] double distance_to_outline_m(const Polygon& polygon, const Eigen::Vector2d& point);
/// First pair of sides (by their first corners) that meet elsewhere than neighbours do at their corner.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> self_crossing(const Polygon& polygon);
/// Convex hull, counter-clockwise (Andrew's monotone chain); fewer than three points as they are, in order.
[[nodiscard]] Polygon convex_hull(std::vector<Eigen::Vector2d> points);

}  // namespace octant
