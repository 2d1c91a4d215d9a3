// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/problem/problem.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "models/arrival_source.h"

namespace octant::calib {

/// Memory that solve() needs for a log with this number of arrivals and odometry rows [bytes], including
/// reading.
[[nodiscard]] std::size_t memory_of_held(std::size_t arrivals, std::size_t odometry_rows = 0);

/// Least memory of solve_streamed(): data of each arrival and state between two passes, states processed
/// singly at the end, and at sites with very many parameters their sums.
/// @param runs  without their arrivals
[[nodiscard]] std::size_t least_memory_streamed(const Site& site,
                                                const std::vector<const MeasurementLog*>& runs,
                                                std::size_t arrivals, std::size_t odometry_rows);

struct StreamedCalibration {
  /// Its runs have evenly spaced epochs (Solution::whole); its trajectories are those of the solution.
  Problem problem;
  Solution solution;
};

/// solve() for a log that does not fit into memory. As solve() does with a long log, it first estimates the
/// shared parameters, except for the noise, from an evenly spread part. Each step of the adjustment is then
/// one pass over the whole log. A pass accumulates sufficient statistics: cost, gradient and Gauss-Newton
/// matrix of all arrivals at the current shared parameters, with all stops and drives solved and eliminated.
/// Near the optimum these suffice for a step of Newton's method. A pass also rejects and readmits arrivals,
/// and three or four passes are enough. The result is that of solve(). Errors: those of reading, of
/// make_problem, and a file that changes meanwhile.
/// @param memory_bytes  bound of the process, which limits the size of the chunks
[[nodiscard]] Result<StreamedCalibration> solve_streamed(const Site& site, ArrivalSource& source,
                                                         const SolveOptions& options,
                                                         std::size_t memory_bytes);

}  // namespace octant::calib
