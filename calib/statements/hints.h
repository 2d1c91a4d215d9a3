// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/log_health.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// Checks a site file alone: positions without any sigma are initial values only and define no frame.
[[nodiscard]] std::vector<Finding> site_hints(const Site& site);

/// Checks the recordings of a calibration before the solution, like `check` (log_health.h). In a long
/// recording evenly spread blocks of rows are examined, which takes a few hundredths of a second for any
/// length. Findings of the site come first.
/// @param are_complete  false if the runs are an evenly spread part of the recordings
[[nodiscard]] std::vector<Finding> log_hints(const Site& site, const std::vector<MeasurementLog>& runs,
                                             bool are_complete = true);

/// Checks the recordings by the solution: receivers whose ranges fit another receiver's position or no
/// position, and jumps of a clock. In a long recording an evenly spread part is examined. Empty without a
/// solution.
[[nodiscard]] std::vector<Finding> outcome_hints(const Problem& problem, const Solution& solution);

}  // namespace octant::calib
