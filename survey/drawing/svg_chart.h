// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "survey/drawing/chart_data.h"

namespace octant::survey {

/// Round numbers from low to high, some `about` of them.
[[nodiscard]] std::vector<double> axis_ticks(double low, double high, int about = 6);

// Charts as self-contained SVG, as site_plan_svg makes them.

/// Mean and RMS of the residuals of each bin.
[[nodiscard]] std::string residual_chart_svg(const ResidualChart& chart);
/// Counts against those that a standard normal distribution would give.
[[nodiscard]] std::string histogram_svg(const Histogram& histogram);
/// Cumulative distribution of the position errors of fixes.
[[nodiscard]] std::string error_curve_svg(const std::vector<double>& quantiles_m,
                                          const std::optional<double>& limit_m);

/// Counts of a bin that a standard normal distribution gives; the outermost bins hold the tails.
[[nodiscard]] std::vector<double> normal_counts(const Histogram& histogram);

}  // namespace octant::survey
