// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/start/approach.h"
#include "calib/statements/refit.h"
#include "models/contradiction.h"

namespace octant::calib {

struct StatementFindings {
  std::vector<Contradiction> contradictions;
  std::optional<Fit>
      fit;  ///< in which nothing that the data contradict is believed any more; none where nothing was tested
};

/// Holds what the site file states against what the data say: control points, speed, delays (or that there
/// are none), receivers, attenuation, taped distances, each against all others.
///
/// First without a new solve. A prior of sigma s that left its parameter at x with variance C is off by v = x
/// - m of variance s^2 - C. A statement that is held (a control point, no delay) is a constraint with the
/// multiplier lambda = the cost's gradient by it; released it would move by d = -(C_lambda)^+ lambda,
/// C_lambda = H_ss - H_sf C H_fs, and the squares would drop by lambda' C_lambda^+ lambda. Only where one of
/// them is beyond chance, or most arrivals of a control point were left out, the suspects are released one at
/// a time and adjusted again, with all arrivals admitted. A suspect is contradicted where what the data then
/// find (with the covariance that holds with their errors) and what was stated differ beyond chance,
/// Bonferroni over all that is tested, and by a length that matters. Of several the one whose release
/// explains most is the culprit; it stays released and the search goes on.
///
/// @param trajectories  solved at the estimate, outliers rejected
/// Empty for sites of more than ParameterLayout::dense_limit parameters, which are not tested.
[[nodiscard]] StatementFindings test_statements(const Problem& problem, const SolveOptions& options,
                                                const Estimate& estimate,
                                                const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
