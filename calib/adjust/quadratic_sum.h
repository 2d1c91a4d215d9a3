// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "calib/adjust/tile_sum.h"

namespace octant::calib {

/// Observations as they look from a point: their cost, gradient and Gauss-Newton matrix there are all that is
/// known of them. What a log leaves of itself when its arrivals are gone.
class QuadraticSum : public SystemSum {
 public:
  /// @param system   at `at`
  /// @param damping  added to the matrix, of its diagonal
  /// @param x        where it is asked for, always the present one; not owned
  QuadraticSum(const ReducedSystem& system, Eigen::VectorXd at, double damping, const Eigen::VectorXd* x)
      : system_(system), at_(std::move(at)), x_(x) {
    system_.H.diagonal() *= 1.0 + damping;
  }
  double solve_states(const SharedState& /*state*/, const RobustLoss& /*loss*/) override {
    const Eigen::VectorXd d = *x_ - at_;
    return system_.cost + d.dot(system_.gradient) + 0.5 * d.dot(system_.H * d);
  }
  void reduce(const SharedState& state, const RobustLoss& loss, ReducedSystem& sum) override {
    sum.cost = solve_states(state, loss);
    sum.gradient = system_.gradient + system_.H * (*x_ - at_);
    sum.H = system_.H;
  }

 private:
  ReducedSystem system_;
  Eigen::VectorXd at_;
  const Eigen::VectorXd* x_;
};

}  // namespace octant::calib
