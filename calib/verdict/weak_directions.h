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
  double limit_m = 0.03;         ///< a combination known worse than half of this is told
  double typical_range_m = 8.0;  ///< turns the speed into metres
  std::size_t most = 3;
};

/// Combinations of parameters of which data and priors together say least: eigenvectors of the joint
/// covariance with all parameters in metres, largest variance first, in words, with the parameters that carry
/// them, the cheapest measurement that settles each, and its consequence at the robot: how far the vehicle
/// states move (RMS, horizontal) when the parameters are off by one sigma along it and the arrivals are
/// explained anew.
/// @param C  joint covariance in internal units  @param usable  beacons that are not undetermined on their
/// own
[[nodiscard]] std::vector<WeakDirection> weak_directions(const ParameterLayout& layout,
                                                         const NameTable& names, const Eigen::VectorXd& x,
                                                         const Covariance& C, const std::vector<bool>& usable,
                                                         const std::vector<Trajectory>& trajectories,
                                                         const WeakDirectionOptions& options);

/// RMS horizontal shift of the vehicle states of up to some thousand segments when the shared parameters go
/// from x to y [m]; for states with a measured pose, of the ranges to them.
[[nodiscard]] double shift_at_robot_m(const ParameterLayout& layout, const Eigen::VectorXd& x,
                                      const Eigen::VectorXd& y, const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
