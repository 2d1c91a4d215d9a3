// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/calibrate.h"
#include "calib/problem/problem.h"

namespace octant::test {

/// Result of the referee: cost at the optimum, values and joint covariance of the free shared parameters, in
/// SI units and in the order of `parameters` (names as in the joint covariance of a solution).
struct RefereeResult {
  bool converged = false;
  double cost = 0.0;
  std::vector<std::string> parameters;
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
};

/// A plain reference: every arrival, odometry step, measured pose and prior is a residual block with
/// automatic derivatives, with all states and parameters at once in Ceres, and covariance by
/// ceres::Covariance (a rank-revealing QR of the whole Jacobian). Planar motion. Starts from a solution
/// displaced by some sigmas and uses the arrivals that the solution uses.
[[nodiscard]] RefereeResult referee(const calib::Problem& problem, const calib::Solution& solution);

}  // namespace octant::test
