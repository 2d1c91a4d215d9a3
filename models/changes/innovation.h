// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/changes/known_parameters.h"

namespace octant {

/// Information of a second visit about changes b of the parameters since the first: y = B b + noise of unit
/// variance. All tests of changes are ordinary least squares. Without changes |y|^2 is chi-square
/// distributed.
struct Innovation {
  Eigen::MatrixXd B;
  Eigen::VectorXd y;
  int degrees_of_freedom = 0;
};

/// Innovation of two independent estimates. @param difference  second minus first  @param covariance
/// covariance of the difference, drift included; positive definite
[[nodiscard]] Innovation innovation_of_difference(const Eigen::VectorXd& difference,
                                                  const Eigen::MatrixXd& covariance);

/// Innovation of a visit with information N, which need not determine all parameters. With P = L L' and L'N L
/// = V diag(l) V', the vector V'L'N (theta_2 - theta_1) has the variances l + l^2 without changes, and the
/// mean diag(l) V'L^-1 b for a change b. Directions that the visit does not observe (l = 0) contribute
/// nothing.
/// @param P  covariance of the first estimate, drift included; positive definite
/// @param N  information of the second visit alone, for its actual errors
/// @param gradient  N (theta_2 - theta_1)
[[nodiscard]] Innovation innovation_of_information(const Eigen::MatrixXd& P, const Eigen::MatrixXd& N,
                                                   const Eigen::VectorXd& gradient);

/// Removes the parts of y that motions along the columns of T could explain, where such motions have no
/// meaning. Motions that are unobservable (no effect at 1 km) are ignored.
[[nodiscard]] Innovation free_of(const Innovation& innovation, const Eigen::MatrixXd& T);

}  // namespace octant
