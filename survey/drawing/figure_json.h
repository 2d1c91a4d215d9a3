// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "survey/drawing/chart_data.h"
#include "survey/drawing/plan_input.h"

namespace octant::survey {

// The drawings as figures of plotly.js: JSON {data, layout}, ASCII, safe inside a script element. Colours are
// names of the page's custom properties ("var(--beacon)"), which its script looks up, so that they follow the
// light or dark scheme.

/// Walls, routes and moves are drawn over the maps, with their names where they are few.
[[nodiscard]] std::string plan_figure_json(const PlanInput& input);
/// Beacons, 95 % ellipsoids as three great circles each, track and fixes in space.
[[nodiscard]] std::string space_figure_json(const PlanInput& input);
[[nodiscard]] std::string residual_chart_json(const ResidualChart& chart);
[[nodiscard]] std::string histogram_json(const Histogram& histogram);
[[nodiscard]] std::string error_curve_json(const std::vector<double>& quantiles_m,
                                           const std::optional<double>& limit_m);

}  // namespace octant::survey
