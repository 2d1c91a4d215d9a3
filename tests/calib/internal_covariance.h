// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "calib/adjust/covariance.h"
#include "calib/problem/parameters.h"
#include "calib/solution/solution.h"

namespace octant::test {

/// A solution's joint covariance in the units of the adjustment, as what comes after it takes it.
inline calib::Covariance internal_covariance(const calib::ParameterLayout& layout,
                                             const calib::Solution& solution) {
  Eigen::VectorXd per_si(layout.size());
  for (int i = 0; i < layout.size(); ++i)
    per_si[i] = 1.0 / layout.parameters[static_cast<std::size_t>(i)].si_per_unit;
  return calib::Covariance(
      Eigen::MatrixXd(per_si.asDiagonal() * solution.covariance.matrix * per_si.asDiagonal()));
}

}  // namespace octant::test
