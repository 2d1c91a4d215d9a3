// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

/// Returns true if an outcome suggests that a site file or log is wrong as a whole: no solution or a poor
/// one, many rejected arrivals, early arrivals that cannot be echoes, noise far above the expected one, or a
/// receiver displaced from its position.
[[nodiscard]] bool seems_misread(const Problem& problem, const Solution& solution);

/// If the outcome suggests that the site file or a log is wrong as a whole, searches for the cause
/// (readings.h). A cause replaces the other contradictions, which are its consequences, and in the message of
/// a refusal it replaces the advice to record more.
/// @param adjusted  problem of the solution: `problem` itself, or a subsampled one
void explain(const Problem& problem, const Problem& adjusted, Solution& solution,
             const SolveOptions& options);

}  // namespace octant::calib
