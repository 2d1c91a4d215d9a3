// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

/// The bundle adjustment: initial values, graduated robust adjustment, rejection, covariance, verdict.
[[nodiscard]] Solution solve(const Problem& problem, const SolveOptions& options = {});
/// Does what solve() does in less memory: it moves the trajectories of a long log from the problem into the
/// solution.
[[nodiscard]] Solution solve_in_place(Problem& problem, const SolveOptions& options = {});

/// Where a deployment came from.
struct Provenance {
  std::string created;  ///< ISO 8601, UTC
  std::string version;
  std::string command;
  std::vector<InputDigest> inputs;
};

/// The deployment of a solution with status kConverged.
[[nodiscard]] Deployment make_deployment(const Problem& problem, const Solution& solution,
                                         const Provenance& provenance);
/// What a deployment takes over from the site and from where it came, whatever the outcome: all but what was
/// solved for.
[[nodiscard]] Deployment deployment_head(const Site& site, const Solution& solution,
                                         const Provenance& provenance);

}  // namespace octant::calib
