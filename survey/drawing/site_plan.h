// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "survey/drawing/plan_input.h"

namespace octant::survey {

/// Above this number of beacons, drawings show dots only: names and ellipses would overlap.
inline constexpr std::size_t kMostNamed = 300;

/// By how much error ellipses are drawn larger than they are, so that the largest is some 5 % of the plan: 1,
/// 2 or 5 times a power of ten, at least 1.
[[nodiscard]] double ellipse_exaggeration(const Deployment& deployment, double plan_extent_m);

/// Magnification of shifts: that of the ellipses if the longest shift is then at most a tenth of the plan,
/// otherwise less.
[[nodiscard]] double move_exaggeration(const PlanInput& input, double plan_extent_m);

/// Plan of a site as a self-contained SVG: grid in metres, maps, area, walls, routes, tracks, fixes, beacons
/// with exaggerated 95 % error ellipses and a legend that says by how much. Follows the reader's light or
/// dark scheme. Undetermined beacons are not drawn: their place is not known. Of several maps the first is
/// shown; the others are layers (see ReportFigure).
[[nodiscard]] std::string site_plan_svg(const PlanInput& input);

/// Beacons and vehicle seen from the side, with their heights.
[[nodiscard]] std::string elevation_svg(const PlanInput& input);

/// Limits between the classes in which a map is drawn, ascending: its own, or geometric where all values are
/// positive.
[[nodiscard]] std::vector<double> map_classes(const NamedMap& map);

}  // namespace octant::survey
