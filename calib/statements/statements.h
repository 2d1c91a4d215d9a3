// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/start/approach.h"
#include "calib/statements/common_errors.h"
#include "calib/statements/refit.h"
#include "models/contradiction.h"

namespace octant::calib {

struct StatementFindings {
  std::vector<Contradiction> contradictions;
  std::vector<std::string> warnings;  ///< of errors that explain only a part of the misfit
  std::vector<CommonError> errors;    ///< that many observations have in common, the clearest first
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
/// Errors that many observations have in common (common_errors.h: a clock that drifts or jumps, poses that
/// are stamped late, a medium that changes) are suspects like the statements, so that one cause is preferred
/// to several statements that would each have to be false. Each is taken out of the observations, which are
/// adjusted again, and its size is refined. It is found where the likelihood, by the noise and the
/// correlation that it leaves, gains more than chance. It contradicts what was stated where it explains most
/// of the misfit; a smaller one is a warning. Of two that are equally likely both are named.
///
/// @param trajectories  solved at the estimate, outliers rejected
/// Empty for sites of more than 2,000 parameters, which are not tested.
[[nodiscard]] StatementFindings test_statements(const Problem& problem, const SolveOptions& options,
                                                const Estimate& estimate,
                                                const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
