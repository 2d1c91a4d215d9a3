// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is known of the shared parameters beside the arrivals: priors of single ones and of several together,
// and taped distances.

#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/parameters.h"

namespace octant::calib {

/// Weighted misfit of a taped distance and its derivative by the free coordinates of both beacons, in layout
/// order.
struct DistanceRow {
  double residual = 0.0;
  std::vector<std::pair<int, double>> entries;  ///< (column, derivative)
};

[[nodiscard]] DistanceRow distance_row(const ControlDistance& distance, const ParameterLayout& layout,
                                       const SharedState& state);

/// 1/2 the weighted squares of priors and control distances at x.
[[nodiscard]] double prior_cost(const Problem& problem, const ParameterLayout& layout,
                                const Eigen::VectorXd& x);

/// Their information.
[[nodiscard]] Eigen::MatrixXd prior_information(const Problem& problem, const ParameterLayout& layout,
                                                const Eigen::VectorXd& x);

/// Visits the elements of the information of priors and control distances as visit(row, column, value), some
/// of them several times.
void for_each_of_prior(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x,
                       const std::function<void(int, int, double)>& visit);

}  // namespace octant::calib
