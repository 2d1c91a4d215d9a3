// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/clocks/clock_fit.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Finds a step of a clock in the residuals of an adjusted problem: in the receptions before and after a
/// time, or in the random walk of the clock.
[[nodiscard]] std::optional<ClockJump> jump_in(const ClockProblem& problem, const ClockFit& fit);

/// Tests the stated positions: each pair of beacons exchanged, each beacon released. Returns the hypothesis
/// that explains the receptions better than the statement, if there is one.
/// @param start  problem of the start  @param x  its solution  @param sigma_m  noise as found
[[nodiscard]] std::optional<Contradiction> wrong_position(ClockProblem start, Eigen::VectorXd x,
                                                          double sigma_m);

}  // namespace octant::calib
