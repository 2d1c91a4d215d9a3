// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "calib/problem/parameters.h"
#include "calib/sums/ranks.h"
#include "calib/sums/reduced_system.h"

namespace octant::calib {

/// Gauss-Newton matrix of arrivals and bearings alone (data) and of priors and control distances (prior) at
/// x, states solved for.
struct Information {
  Eigen::MatrixXd data, prior;
  double data_cost = 0.0;
  Eigen::VectorXd data_gradient;  ///< of data_cost
};
[[nodiscard]] Information information_at(const Problem& problem, const ParameterLayout& layout,
                                         std::vector<Trajectory>& trajectories, const Eigen::VectorXd& x,
                                         const Workers& workers = {});
/// The matrix of data and priors together, for sites where the dense one would be too large: it has all
/// elements of parameters that some stop, prior or taped distance connects, both triangles.
/// @param data  at x
[[nodiscard]] Eigen::SparseMatrix<double> sparse_information(const Problem& problem,
                                                             const ParameterLayout& layout,
                                                             const Eigen::VectorXd& x,
                                                             std::vector<SystemPart> data);
/// Information of all observations, with the states solved.
[[nodiscard]] Eigen::SparseMatrix<double> sparse_information_at(const Problem& problem,
                                                                const ParameterLayout& layout,
                                                                std::vector<Trajectory>& trajectories,
                                                                const Eigen::VectorXd& x,
                                                                const Workers& workers = {});

}  // namespace octant::calib
