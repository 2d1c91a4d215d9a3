// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "calib/statements/refit.h"
#include "models/changes/known_parameters.h"
#include "models/deployment.h"

namespace octant::calib {

/// Information of a second visit alone on the known parameters. SI units, in their order.
struct VisitInformation {
  Eigen::MatrixXd N;         ///< information with correlated errors; may be singular
  Eigen::VectorXd gradient;  ///< N (theta_2 - theta_1): direction of the change
  bool correlated = false;   ///< errors are correlated, which reduces N
};

/// Computes it from the gradient g and the Gauss-Newton matrix N of the arrivals at a fit x near theta_2:
///   N (theta_2 - x) = -g,   so that   N (theta_2 - theta_1) = N (x - theta_1) - g
/// All other parameters are eliminated with their priors. If errors are correlated, by the residuals or in
/// the first calibration, estimates with white weights have the covariance G (P^-1 + M) G with G = (P^-1 +
/// N)^-1, and the information of the visit is N M^-1 N (the inverse of Huber's sandwich).
/// @param fit  with the joint prior of set_joint_prior; its states are solved here
/// @param P  covariance of that prior [SI]
/// @param noise  of the first calibration
/// @param known_white  a part of the same recording has shown that errors are white; not tested again
[[nodiscard]] VisitInformation visit_information(Fit& fit, const KnownParameters& known,
                                                 const Eigen::MatrixXd& P, const Deployment& noise,
                                                 int threads, bool known_white = false);

/// Combines the covariance of a visit's estimates under the errors of the first calibration with that under
/// the errors that the visit's residuals show. A short visit determines its errors badly, so the larger one
/// applies, by the mean ratio of its variances to the white ones. If these are nearly equal, within
/// exp(+-1/4), both are mixed by the logarithm of their ratio, so that random draws in the model do not
/// switch the result.
/// @param white  under white errors; positive diagonal, same size as the others
[[nodiscard]] Eigen::MatrixXd between_error_models(const Eigen::MatrixXd& white,
                                                   const Eigen::MatrixXd& stated,
                                                   const Eigen::MatrixXd& shown);

/// Gaussian prior with mean theta_1, updated by a visit.
struct Updated {
  Eigen::VectorXd step;  ///< from theta_1
  Eigen::MatrixXd covariance;
};
/// Computes (P^-1 + N)^-1 and its product with the gradient.
/// @param P  positive definite
[[nodiscard]] Updated updated_by(const Eigen::MatrixXd& P, const Eigen::MatrixXd& N,
                                 const Eigen::VectorXd& gradient);

}  // namespace octant::calib
