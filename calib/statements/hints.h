// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/log_health.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// What is odd about a site file by itself: places without any sigma, which serve as a start and hold
/// nothing.
[[nodiscard]] std::vector<Finding> site_hints(const Site& site);

/// What `check` says of the recordings before anything is solved (log_health.h), for a calibration: of a long
/// recording evenly spread blocks of rows are looked at, which takes a few hundredths of a second whatever
/// its length. Those of the site come first.
/// @param are_complete  false: the runs are an evenly spread part of the recordings
[[nodiscard]] std::vector<Finding> log_hints(const Site& site, const std::vector<MeasurementLog>& runs,
                                             bool are_complete = true);

/// What the outcome shows of the recordings: receivers whose ranges fit another's place or none, jumps of a
/// clock. An evenly spread part of a long recording is looked at. Nothing where nothing was solved.
[[nodiscard]] std::vector<Finding> outcome_hints(const Problem& problem, const Solution& solution);

}  // namespace octant::calib
