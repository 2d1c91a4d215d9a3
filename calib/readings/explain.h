// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

/// Whether a calibration came out as one does whose site file or log is wrong as a whole: no or a poor
/// outcome, many arrivals left out, more than a few of them early, which no echo can be, noise many times the
/// stated one, or a receiver dragged from its place.
[[nodiscard]] bool seems_misread(const Problem& problem, const Solution& solution);

/// Where the outcome looks as if the site file or a log were wrong as a whole, names what is (readings.h): as
/// contradictions, in place of others, which are its consequences, and in the message of a refusal, in place
/// of a measurement that would not help.
/// @param adjusted  what the solution is of: the problem, or a subsampled one
void explain(const Problem& problem, const Problem& adjusted, Solution& solution,
             const SolveOptions& options);

}  // namespace octant::calib
