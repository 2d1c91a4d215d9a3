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

using Polygon = std::vector<Eigen::Vector2d>;  ///< corners in order; the last is joined to the first

/// Smallest axis-parallel rectangle that contains all points; empty if there are no points.
[[nodiscard]] Eigen::AlignedBox2d bounds_of(std::span<const Eigen::Vector2d> points);

/// Signed area, positive for counter-clockwise corners [m^2].
[[nodiscard]] double signed_area_m2(const Polygon& polygon);
/// Even-odd test. Points on the outline may give either result.
[[nodiscard]] bool is_inside(const Polygon& polygon, const Eigen::Vector2d& point);
/// Point of the outline that is nearest to a point. @param polygon  not empty
[[nodiscard]] Eigen::Vector2d nearest_on_outline(const Polygon& polygon, const Eigen::Vector2d& point);
/// Distance of a point inside or outside from the outline.
[[nodiscard]] double distance_to_outline_m(const Polygon& polygon, const Eigen::Vector2d& point);
/// Returns the first pair of sides (by their first corners) that meet, other than neighbours at their common
/// corner.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> self_crossing(const Polygon& polygon);
/// Convex hull, counter-clockwise (Andrew's monotone chain). Fewer than three points are returned in order.
[[nodiscard]] Polygon convex_hull(std::vector<Eigen::Vector2d> points);

}  // namespace octant
