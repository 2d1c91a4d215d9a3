// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/adjust/covariance.h"
#include "calib/adjust/estimate.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

/// Covariance, status of the beacons, weak directions, verdict: fills the solution. Returns the covariance in
/// internal units. Beyond ParameterLayout::dense_limit the solution's joint covariance stays empty and its
/// marginals are filled instead. A beacon is undetermined when it was not found or the sigma of its worst
/// direction is beyond the site's tolerance. The data refuse (SolveStatus::kUndetermined) when half or more
/// of the beacons asked for are, or when speed, a common delay or a receiver array are not known to that
/// tolerance and a beacon or a typical fix (fix_shift.h) is off beyond its own by that.
[[nodiscard]] Covariance judge(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                               std::vector<Trajectory>& trajectories, Solution& solution);

}  // namespace octant::calib
