// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "calib/adjust/ranks.h"
#include "calib/problem/parameters.h"
#include "calib/problem/problem.h"
#include "calib/solution.h"

namespace octant::calib {

/// Progress of a calibration: stage in words, iteration within it, cost.
struct Progress {
  std::string stage;
  int iteration = 0;
  double cost = 0.0;
  double fraction = 0.0;  ///< 0..1 of the whole, an estimate
};

struct SolveOptions {
  int threads = 1;
  const Ranks* ranks =
      nullptr;               ///< processes that solve this together, all given the same problem; not owned
  int max_iterations = 100;  ///< of each stage; the last, which comes to rest, may take four times as many
  double rejection_sigmas = 4.0;  ///< arrivals beyond this many sigmas are left out in the end
  int dense_limit = kDenseLimit;  ///< beyond so many shared parameters matrices are sparse
  bool strict = false;            ///< a single undetermined beacon refuses the whole
  /// Called between iterations; returning false stops with SolveStatus::kInterrupted.
  std::function<bool(const Progress&)> on_progress;

  [[nodiscard]] Workers workers() const { return {threads, ranks}; }
};

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
