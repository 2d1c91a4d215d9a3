// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/problem/log_totals.h"
#include "calib/problem/problem.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// Observations that an adjustment rejected, with reasons.
struct LeftOutOfAll {
  std::vector<LeftOut> arrivals;
  std::vector<LeftOutBearing> bearings;
  std::vector<LeftOutPose> poses;
};

/// Collects the rejected observations.
/// @param trajectories  solved, outliers rejected at `state`
[[nodiscard]] LeftOutOfAll left_out_of(const Problem& problem, const std::vector<Trajectory>& trajectories,
                                       const SharedState& state);

/// Numbers of all arrivals of a log by outcome, also for streamed logs.
/// @param problem  problem of the solution
[[nodiscard]] RejectionCounts arrivals_by_outcome(const Problem& problem, const Solution& solution);
/// Returns true if more than a third of the arrivals are rejected: an input is misread, or the clock is not
/// consistent.
[[nodiscard]] bool are_many_left_out(const Problem& problem, const Solution& solution);

/// Warnings on beacons if more than half of their labelled bearings disagree.
[[nodiscard]] std::vector<std::string> bearings_in_doubt(const Problem& problem,
                                                         const std::vector<LeftOutBearing>& left_out);

}  // namespace octant::calib
