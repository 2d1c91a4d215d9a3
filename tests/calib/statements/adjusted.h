// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/adjust/information.h"
#include "calib/statements/common_errors.h"
#include "tests/calib/calib_support.h"

namespace octant::test {

/// Shared parameters of a solution, with the inverse of the dense information.
struct Adjusted {
  Adjusted(const World& world, const calib::Solution& solution)
      : problem(problem_of(world)),
        layout(calib::make_layout(problem, solution.state)),
        x(layout.vector_of(solution.state)) {
    std::vector<Trajectory> trajectories = solution.trajectories;
    const calib::Information information = calib::information_at(problem, layout, trajectories, x);
    covariance = calib::Covariance(Eigen::MatrixXd(information.data + information.prior), {});
  }
  [[nodiscard]] calib::AdjustedParameters parameters() const { return {layout, covariance}; }

  calib::Problem problem;
  calib::ParameterLayout layout;
  Eigen::VectorXd x;
  calib::Covariance covariance;
};

}  // namespace octant::test
