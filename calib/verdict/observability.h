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

/// Computes covariance, status of the beacons, weak directions and verdict, and fills the solution. Returns
/// the covariance in internal units. Beyond ParameterLayout::dense_limit only the marginals of the solution's
/// covariance are filled.
///
/// A beacon is undetermined if it was not received, or if the sigma of its worst direction exceeds the site's
/// tolerance. The calibration is refused (SolveStatus::kUndetermined) if half or more of the required beacons
/// are undetermined. It is also refused if the uncertainty of the speed, a common delay or a receiver array
/// exceeds that tolerance and moves a beacon or a typical fix (fix_shift.h) by more than its own tolerance.
[[nodiscard]] Covariance judge(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                               std::vector<Trajectory>& trajectories, Solution& solution);

}  // namespace octant::calib
