// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "calib/adjust/adjust_options.h"
#include "calib/problem/parameters.h"
#include "calib/sums/reduced_system.h"

namespace octant::calib {

class SystemSum;

struct AdjustResult {
  bool converged = false;
  bool interrupted = false;
  int iterations = 0;
  double cost = 0.0;    ///< 1/2 sum of rho, priors and control distances included
  std::string message;  ///< why it stopped, Ceres's own words where it was Ceres that found so
  /// All arrivals and bearings under the loss of the adjustment, where their system was formed as a whole, or
  /// is all that is known of them: at x, or before a last step that changes its matrix by less than a part in
  /// a thousand.
  std::optional<SystemParts> data;
};

/// One adjustment of all shared parameters by Ceres: the sum of all tiles is one cost function (at sites with
/// very many parameters each tile is one, over the parameter blocks it touches, and the linear system is
/// sparse). With H = R'R its residual is z = R^-T g and one more row sqrt(2 cost - z'z); its Jacobian is R
/// and a row of zeros. Ceres therefore uses the cost, gradient and Gauss-Newton matrix of the full bundle
/// adjustment.
/// @param x  start and result, order of the layout
/// @param trajectories  states and rejections; at the end, states are solved at x
AdjustResult adjust(const Problem& problem, const ParameterLayout& layout,
                    std::vector<Trajectory>& trajectories, Eigen::VectorXd& x, const AdjustOptions& options);

/// Adjusts observations that are no tiles.
AdjustResult adjust(const Problem& problem, const ParameterLayout& layout, SystemSum& observations,
                    Eigen::VectorXd& x, const AdjustOptions& options);

}  // namespace octant::calib
