// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/changes/known_parameters.h"

namespace octant {

/// What a second visit says of changes b of the parameters since the first: y = B b + noise of unit variance,
/// so that all tests of changes are ordinary least squares. Without any change |y|^2 is chi-square.
struct Innovation {
  Eigen::MatrixXd B;
  Eigen::VectorXd y;
  int degrees_of_freedom = 0;
};

/// Innovation of two independent estimates. @param difference  second less first  @param covariance  of it,
/// drift included; positive definite
[[nodiscard]] Innovation innovation_of_difference(const Eigen::VectorXd& difference,
                                                  const Eigen::MatrixXd& covariance);

/// Innovation of a visit that need not determine everything, by its information N alone.
/// With P = L L' and L'N L = V diag(l) V' the vector V'L'N (theta_2 - theta_1) has the variances l + l^2
/// where nothing changed and the mean diag(l) V'L^-1 b where b did; directions that the visit does not see (l
/// = 0) say nothing.
/// @param P  covariance of the first estimate, drift included; positive definite
/// @param N  information of the second visit alone, with the errors as they are
/// @param gradient  N (theta_2 - theta_1)
[[nodiscard]] Innovation innovation_of_information(const Eigen::MatrixXd& P, const Eigen::MatrixXd& N,
                                                   const Eigen::VectorXd& gradient);

/// The innovation where motions along the columns of T have no meaning: it loses the parts of y that they
/// could explain. Motions that are not observable (a kilometre passes unnoticed) take nothing away.
[[nodiscard]] Innovation free_of(const Innovation& innovation, const Eigen::MatrixXd& T);

}  // namespace octant
