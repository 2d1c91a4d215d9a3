// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/adjust/adjust.h"
#include "calib/calibrate.h"
#include "calib/problem/parameters.h"
#include "calib/start/progress_monitor.h"

namespace octant::calib {

/// Shared parameters as they are known at some point of a calibration.
struct Estimate {
  ParameterLayout layout;
  Eigen::VectorXd x;
  AdjustResult last;                  ///< of the adjustment that led to x
  double noise_factor = 1.0;          ///< noise of the arrivals as found over the stated one
  double pose_factor = 1.0;           ///< the same of measured poses
  std::vector<bool> beacon_usable;    ///< found
  std::vector<bool> beacon_mirrored;  ///< a second place, adjusted as well, is as good by all observations

  [[nodiscard]] SharedState state() const { return layout.state_of(x); }
  /// Noise of a range.
  [[nodiscard]] double sigma_m(const Problem& problem) const {
    return problem.site.noise.tof_sigma_s * noise_factor * layout.nominal_speed_mps;
  }
};

/// From nothing to shared parameters and states that the largest consensus of arrivals agrees on.
struct Approach {
  bool ok = false;  ///< false: `why_not` has status, message and weak directions
  Solution why_not;
  Estimate estimate;
  std::vector<Trajectory> trajectories;
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
