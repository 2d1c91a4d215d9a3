// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/problem/log_totals.h"
#include "calib/problem/problem.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// What took no part in an adjustment, with its reason.
struct LeftOutOfAll {
  std::vector<LeftOut> arrivals;
  std::vector<LeftOutBearing> bearings;
  std::vector<LeftOutPose> poses;
};

/// @param trajectories  solved, outliers rejected at `state`
[[nodiscard]] LeftOutOfAll left_out_of(const Problem& problem, const std::vector<Trajectory>& trajectories,
                                       const SharedState& state);

/// All arrivals of a log by what became of them, streamed or not. @param problem  that the solution is of
[[nodiscard]] RejectionCounts arrivals_by_outcome(const Problem& problem, const Solution& solution);
/// More than a third of the arrivals: what was stated is misread, or the recording is not of one clock.
[[nodiscard]] bool are_many_left_out(const Problem& problem, const Solution& solution);

/// Warnings that name beacons of whose labelled bearings more than half do not fit all else.
[[nodiscard]] std::vector<std::string> bearings_in_doubt(const Problem& problem,
                                                         const std::vector<LeftOutBearing>& left_out);

}  // namespace octant::calib
