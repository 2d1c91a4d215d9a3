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
  std::vector<std::string> warnings;  ///< errors that explain only a part of the misfit
  std::vector<CommonError> errors;    ///< errors common to many observations, most significant first
  std::optional<Fit> as_stated;       ///< fit with all assumptions; no value without tests
  std::optional<Fit> fit;  ///< fit with all contradicted assumptions released; no value without tests
};

/// Tests the assumptions of the site file against the data: control points, speed, delays (or their absence),
/// receivers, attenuation, taped distances, each given all others.
///
/// The first step needs no new solution. A prior with mean m and sigma s whose parameter is adjusted to x
/// with variance C deviates by v = x - m with variance s^2 - C. A fixed value (a control point, no delay) is
/// a constraint whose multiplier lambda is the gradient of the cost. Its release would move it by d =
/// -(C_lambda)^+ lambda with C_lambda = H_ss - H_sf C H_fs, and would reduce the squares by lambda'
/// C_lambda^+ lambda.
///
/// If a deviation is significant, or most arrivals of a control point were rejected, each suspect is released
/// and adjusted again with all arrivals admitted. It is contradicted if the value of this fit differs from
/// the site file significantly (covariance with correlated errors, Bonferroni correction over all tests) and
/// by a relevant length. The suspect whose release explains most is the culprit. It remains released and the
/// search continues.
///
/// Some assumptions have a single alternative instead of a free value: heights that count downwards, and two
/// beacons at each other's positions, which is tried if one is found at the stated position of the other.
///
/// Errors that many observations have in common (common_errors.h: a clock that drifts or jumps, poses with a
/// time lag, a medium that changes) are suspects too, so that one cause is preferred to several false
/// assumptions. The observations are corrected for each error and adjusted again, and its size is refined. An
/// error is found if the gain in likelihood, for the remaining noise and correlation, is significant. It is a
/// contradiction if it explains most of the misfit, otherwise a warning. If two errors are equally likely,
/// both are named.
///
/// @param trajectories  solved at the estimate, outliers rejected
/// @return empty for sites of more than 2,000 parameters, which are not tested
[[nodiscard]] StatementFindings test_statements(const Problem& problem, const SolveOptions& options,
                                                const Estimate& estimate,
                                                const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
