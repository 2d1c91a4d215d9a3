// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/adjust.h"
#include "calib/parameters.h"
#include "models/deployment.h"

namespace octant::calib {

/// Counts, redundancy, variance factor and its two-sided chi-square test, from settled trajectories.
/// @param cost  1/2 the weighted sum of squares of everything, priors included
[[nodiscard]] CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout,
                                                  const std::vector<Trajectory>& trajectories, const SharedState& state, double cost,
                                                  int threads = 1);

/// Two-sided p value of a sum of squares against chi-square with the given degrees of freedom.
[[nodiscard]] double chi_square_p(double sum_of_squares, double degrees_of_freedom);

}  // namespace octant::calib
