// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/adjust/adjust.h"
#include "calib/problem/parameters.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Shared parameters at some point of a calibration.
struct Estimate {
  ParameterLayout layout;
  Eigen::VectorXd x;
  AdjustResult last = {};                ///< result of the adjustment that led to x
  double noise_factor = 1.0;             ///< noise of the arrivals as found over the stated one
  double pose_factor = 1.0;              ///< factor of the sigmas of measured poses
  std::vector<bool> beacon_usable = {};  ///< found
  /// A second place of a beacon, adjusted as well, is as good by all observations.
  std::vector<bool> beacon_mirrored = {};
  [[nodiscard]] SharedState state() const { return layout.state_of(x); }
  /// Noise of a range.
  [[nodiscard]] double sigma_m(const Problem& problem) const {
    return problem.site.noise.tof_sigma_s * noise_factor * layout.nominal_speed_mps;
  }
};

/// An estimate with its vehicle states.
struct AdjustedLog {
  Estimate estimate;
  std::vector<Trajectory> trajectories;
};

}  // namespace octant::calib
