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

/// Significance from which an error is a hypothesis. White noise rarely reaches it in any of the many tests.
inline constexpr double kBeyondChance = 6.0;

/// Finds errors that many observations have in common, if the residuals show them more clearly than white
/// noise would (score_test.h). Returns the most significant error of each kind, for each recording and for
/// odometry. They are hypotheses: an error that is not modelled makes its own residuals look correlated, so
/// only an adjustment without it gives its significance (statements.h). In a long recording an evenly spread
/// part is examined.
/// @param trajectories  adjusted; parameters.share is their share of those from which the parameters are
[[nodiscard]] std::vector<CommonError> common_errors(const std::vector<Trajectory>& trajectories,
                                                     const SharedState& state,
                                                     const AdjustedParameters& parameters, int threads = 1,
                                                     double least_sigmas = kBeyondChance);

/// Describes an error as a contradiction of what is assumed of the recordings, with its remedy.
[[nodiscard]] Contradiction contradiction_of(const CommonError& error, const Site& site,
                                             const std::vector<MeasurementLog>& runs);

/// "from 12.5 s on times of flight are 0.12 ms longer"
[[nodiscard]] std::string jump_in_words(double time_s, double step_s);

/// Corrects the trajectories of its run for an error (all runs for an error of the odometry).
/// @param state  adjusted parameters, for directions
void take_back(const CommonError& error, const SharedState& state, std::vector<Trajectory>& trajectories);
/// Corrects the observations of a run for an error.
/// @param span_s  times of the first and the last arrival of the whole recording
void take_back(const CommonError& error, std::pair<double, double> span_s, MeasurementLog& run);
/// Times of the first and the last arrival of a recording; infinite if there are no arrivals.
[[nodiscard]] std::pair<double, double> span_of(const std::vector<Arrival>& arrivals);

}  // namespace octant::calib
