// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/problem/problem.h"
#include "models/deployment.h"
#include "models/trajectory/shared_state.h"

namespace octant::calib {

/// Reviews the ranges between beacons against an adjustment without them. Their deviations from the computed
/// times have the covariance of the ranges plus that of the computed times (innovations). Sets the sigma of
/// the beacons' delays to its most likely value, at least the noise and at most the prior of the delays in
/// the site file, and leaves out ranges that deviate by more than four sigmas from the others, the worst
/// first.
/// @param covariance  of the shared parameters of that adjustment
/// @return a sentence for each range that is left out
[[nodiscard]] std::vector<std::string> review_ranges(Problem& problem, const SharedState& state,
                                                     const JointCovariance& covariance);

}  // namespace octant::calib
