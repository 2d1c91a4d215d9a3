// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/adjust/estimate.h"
#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "calib/verdict/conclude.h"

namespace octant::calib {

/// Names what contradicts the data: statements of the site file, beacons that moved, errors that many
/// observations have in common. Adds contradictions, common errors and warnings to a complete solution,
/// within its budget (diagnosis_budget.h).
/// @param estimate  that the solution was concluded from
void diagnose(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
              const Conclusion& concluded, Solution& solution);

}  // namespace octant::calib
