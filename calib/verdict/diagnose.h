// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/adjust/estimate.h"
#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "calib/verdict/conclude.h"

namespace octant::calib {

/// Finds what contradicts the data: assumptions of the site file, beacons that moved, errors common to many
/// observations. Adds contradictions and common errors to a complete solution, within its budget
/// (diagnosis_budget.h).
/// @param estimate  estimate that led to the solution
void diagnose(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
              Solution& solution);

/// Adds warnings of noise, correlated errors, shadows and control points to a solution without
/// contradictions, which would have such consequences.
/// @param shadowed  warning of conclude(), or an empty text
void add_warnings(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                  const std::string& shadowed, Solution& solution);

}  // namespace octant::calib
