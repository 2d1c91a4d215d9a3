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

/// Bytes that solve() needs for a log of so many arrivals and, of drives, odometry rows, reading included.
[[nodiscard]] std::size_t memory_of_held(std::size_t arrivals, std::size_t odometry_rows = 0);

/// The least that solve_streamed() needs: what is known of each arrival and each state between two readings,
/// the states that are looked at one by one in the end, and at sites of very many parameters their sums.
/// @param runs  without their arrivals
[[nodiscard]] std::size_t least_memory_streamed(const Site& site,
                                                const std::vector<const MeasurementLog*>& runs,
                                                std::size_t arrivals, std::size_t odometry_rows);

struct StreamedCalibration {
  /// Its runs hold every so many-th epoch (Solution::whole), its trajectories are the solution's.
  Problem problem;
  Solution solution;
};

/// solve() for a log that would not fit into memory: an evenly spread part of it tells the shared parameters
/// but for the noise, as solve() does with a long log; then the whole is read again for each step of the
/// adjustment. What it leaves each time is its sufficient data: cost, gradient and Gauss-Newton matrix of all
/// arrivals at the shared parameters of the step, all stops or drives solved and eliminated. Near the
/// optimum that is all there is to know, so one reading is one step of Newton's method; it rejects and
/// readmits arrivals by the way, and three or four of them are enough. The answer is that of solve(). Errors:
/// those of reading, of make_problem, and a file that changes meanwhile.
/// @param memory_bytes  bound of the process, by the size of what is read at once
[[nodiscard]] Result<StreamedCalibration> solve_streamed(const Site& site, ArrivalSource& source,
                                                         const SolveOptions& options,
                                                         std::size_t memory_bytes);

}  // namespace octant::calib
