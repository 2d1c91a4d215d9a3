// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

/// The bundle adjustment: initial values, graduated robust adjustment, rejection, covariance, verdict.
[[nodiscard]] Solution solve(const Problem& problem, const SolveOptions& options = {});
/// Does what solve() does in less memory: it moves the trajectories of a long log from the problem into the
/// solution.
[[nodiscard]] Solution solve_in_place(Problem& problem, const SolveOptions& options = {});

}  // namespace octant::calib
