// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/calibrate.h"
#include "calib/problem/problem.h"

namespace octant::calib {

/// A solution of which nothing came but the word that it was stopped.
[[nodiscard]] Solution interrupted_solution();

/// Nothing is solved, as the data do not determine a direction; what would settle it is said.
[[nodiscard]] Solution refused(WeakDirection direction);

/// Refused because no pose of the vehicle was found. @param beacon_found  those that were placed
[[nodiscard]] Solution without_any_pose(const Problem& problem, const std::vector<bool>& beacon_found);

}  // namespace octant::calib
