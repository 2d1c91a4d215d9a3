// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/adjust/covariance.h"
#include "calib/problem/parameters.h"
#include "calib/solution/solution.h"

namespace octant::calib {

struct WeakDirectionOptions {
  double limit_m = 0.03;         ///< combinations with a sigma above half of this are reported
  double typical_range_m = 8.0;  ///< converts the speed to metres
  std::size_t most = 3;
};

/// Combinations of parameters that data and priors determine worst: eigenvectors of the joint covariance with
/// all parameters in metres, largest variance first. Each has a description, its parameters, the cheapest
/// measurement that determines it, and its effect at the robot: the shift of the vehicle states (RMS,
/// horizontal) when the parameters change by one sigma along it and the states are solved again.
/// @param C  joint covariance in internal units
/// @param usable  beacons that are not themselves undetermined
[[nodiscard]] std::vector<WeakDirection> weak_directions(const ParameterLayout& layout,
                                                         const NameTable& names, const Eigen::VectorXd& x,
                                                         const Covariance& C, const std::vector<bool>& usable,
                                                         const std::vector<Trajectory>& trajectories,
                                                         const WeakDirectionOptions& options);

/// RMS horizontal shift of the vehicle states, in up to about a thousand segments, when the shared parameters
/// change from x to y [m]. For states with a measured pose, RMS change of their ranges.
[[nodiscard]] double shift_at_robot_m(const ParameterLayout& layout, const Eigen::VectorXd& x,
                                      const Eigen::VectorXd& y, const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
