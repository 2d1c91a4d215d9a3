// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/adjust/estimate.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "calib/start/progress_monitor.h"

namespace octant::calib {

/// From no initial values to shared parameters and states that agree with the largest consensus of arrivals.
struct Approach : AdjustedLog {
  bool ok = false;  ///< false: `why_not` has status, message and weak directions
  Solution why_not;
  std::vector<std::vector<double>> start_headings_rad;  ///< where the search left them (see flips.h)
  std::vector<std::string> warnings;
};

/// Initial values; the adjustment with a loss whose scale goes from the uncertainty of the start down to the
/// noise, states searched again on the way; exchanged and misplaced beacons mended; states searched again
/// with less and less trust in the beacons withdrawn.
/// @param search_again  false: without that last search, which takes most of the time where arrivals do not
/// agree
[[nodiscard]] Approach approach(const Problem& problem, const SolveOptions& options, ProgressMonitor& monitor,
                                bool search_again = true);

}  // namespace octant::calib
