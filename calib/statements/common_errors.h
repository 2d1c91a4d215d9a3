// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/errors/common_error.h"
#include "calib/statements/score_test.h"
#include "models/contradiction.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Those that residuals show beyond the chance of white noise (score_test.h), of each recording and of
/// odometry the clearest first, one of a kind. They are hypotheses: an error that is not in the adjustment
/// makes its own residuals look correlated, so only an adjustment without it says how sure it is
/// (statements.h). Of a long recording an evenly spread part is examined.
/// @param trajectories  adjusted; parameters.share says which part of those that the parameters are from
[[nodiscard]] std::vector<CommonError> common_errors(const std::vector<Trajectory>& trajectories,
                                                     const SharedState& state,
                                                     const AdjustedParameters& parameters, int threads = 1);

/// What it says against what is taken for granted, and what to do about it.
[[nodiscard]] Contradiction contradiction_of(const CommonError& error, const Site& site,
                                             const std::vector<MeasurementLog>& runs);

/// "from 12.5 s on times of flight are 0.12 ms longer"
[[nodiscard]] std::string jump_in_words(double time_s, double step_s);

/// Takes the error out of the trajectories of its run (all runs, if it is odometry's).
void take_back(const CommonError& error, std::vector<Trajectory>& trajectories);
/// Takes the error out of a run: observations as they would have been without it.
/// @param span_s  of the whole recording's arrivals: when the first and the last came
void take_back(const CommonError& error, std::pair<double, double> span_s, MeasurementLog& run);
/// When the first and the last arrival of a recording came; infinite where there is none.
[[nodiscard]] std::pair<double, double> span_of(const std::vector<Arrival>& arrivals);

}  // namespace octant::calib
