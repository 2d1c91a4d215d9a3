// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Information on the shared parameters other than arrivals: priors of single ones and of several together,
// and taped distances.

#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/parameters.h"

namespace octant::calib {

/// One whitened observation of the shared parameters alone.
struct PriorRow {
  double residual = 0.0;
  std::vector<std::pair<int, double>> entries;  ///< (column, derivative)
};

/// A taped distance, by the free coordinates of both beacons.
[[nodiscard]] PriorRow distance_row(const ControlDistance& distance, const ParameterLayout& layout,
                                    const SharedState& state);

/// Ranges between beacons: computed less observed times of flight [s].
[[nodiscard]] Eigen::VectorXd range_residuals_s(const Problem& problem, const SharedState& state);

/// Derivatives of the computed time of flight by shared parameters, in SI units.
[[nodiscard]] std::vector<std::pair<ParameterId, double>> range_derivatives(const Problem& problem,
                                                                            const SharedState& state,
                                                                            const BeaconRange& range);

/// A row for the prior of each parameter (zeros without a prior), then rows for taped distances, for ranges
/// between beacons and for priors of several parameters together. The columns of each row do not depend on x.
[[nodiscard]] std::vector<PriorRow> prior_rows(const Problem& problem, const ParameterLayout& layout,
                                               const Eigen::VectorXd& x);

/// 1/2 the squares of all these rows at x.
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
