// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace octant::test {

/// Derivative of a vector function by central differences, column by column. Error some step^2, and rounding
/// of f / step.
template <class F>
Eigen::MatrixXd numeric_jacobian(const F& f, const Eigen::VectorXd& x, double step = 1e-6) {
  Eigen::MatrixXd J;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd high = x, low = x;
    high[i] += step;
    low[i] -= step;
    const Eigen::VectorXd column = (f(high) - f(low)) / (high[i] - low[i]);
    if (i == 0) J.resize(column.size(), x.size());
    J.col(i) = column;
  }
  return J;
}

}  // namespace octant::test
