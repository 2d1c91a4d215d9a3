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

/// Robust initialisation: shared parameters and states that agree with the largest consensus of arrivals.
struct Approach : AdjustedLog {
  bool ok = false;  ///< false: `why_not` has status, message and weak directions
  Solution why_not;
  std::vector<std::vector<double>> start_headings_rad;  ///< headings after the search (see flips.h)
  std::vector<std::string> warnings;
};

/// Steps: initial values; adjustment with a loss whose scale decreases from the uncertainty of the start to
/// the noise, with states searched again; correction of exchanged and misplaced beacons; a new search of
/// states while the uncertainty of the beacons decreases.
/// @param search_again  false: without that last search, which takes most of the time if arrivals do not
/// agree
[[nodiscard]] Approach approach(const Problem& problem, const SolveOptions& options, ProgressMonitor& monitor,
                                bool search_again = true);

}  // namespace octant::calib
