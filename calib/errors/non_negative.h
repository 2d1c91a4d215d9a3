// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace octant::calib {

/// Least squares with non-negative unknowns, |A x - b| (Lawson and Hanson 1974, algorithm NNLS).
/// @param A  rows x unknowns
[[nodiscard]] Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace octant::calib
