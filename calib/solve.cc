// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include "calib/solve.h"

#include "calib/calibrator.h"
#include "calib/log/held_log.h"

namespace octant::calib {

namespace {

Solution solve_held(const Problem& problem, const SolveOptions& options,
                    std::vector<Trajectory>* own_trajectories) {
  ProgressMonitor monitor(options);
  HeldLog log(problem, options, monitor, own_trajectories);
  return *solve_log(log, options, monitor);  // without reading there is no error
}

}  // namespace

Solution solve(const Problem& problem, const SolveOptions& options) {
  return solve_held(problem, options, nullptr);
}

Solution solve_in_place(Problem& problem, const SolveOptions& options) {
  return solve_held(problem, options, &problem.trajectories);
}

}  // namespace octant::calib
