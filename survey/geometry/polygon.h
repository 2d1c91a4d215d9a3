// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace octant::survey {

using Polygon = std::vector<Eigen::Vector2d>;  ///< corners in order, the last joins the first

/// Twice the signed area is positive where the corners go counter-clockwise.
[[nodiscard]] double signed_area_m2(const Polygon& polygon);
/// By even and odd crossings; on the outline either.
[[nodiscard]] bool is_inside(const Polygon& polygon, const Eigen::Vector2d& point);
[[nodiscard]] double distance_to_outline_m(const Polygon& polygon, const Eigen::Vector2d& point);
/// First pair of sides (by their first corners) that meet elsewhere than neighbours do at their corner.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> self_crossing(const Polygon& polygon);
/// Convex hull, counter-clockwise (Andrew's monotone chain).
[[nodiscard]] Polygon convex_hull(std::vector<Eigen::Vector2d> points);

}  // namespace octant::survey
