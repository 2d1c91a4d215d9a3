// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "calib/statements/refit.h"
#include "models/changes/known_parameters.h"
#include "models/deployment.h"

namespace octant::calib {

/// What a second visit says on its own of the parameters that the first one knew. SI units, order of these.
struct VisitInformation {
  Eigen::MatrixXd N;         ///< information, with the errors as they are; no rank is asked for
  Eigen::VectorXd gradient;  ///< N (theta_2 - theta_1): where the visit pulls from what was known
  bool correlated = false;   ///< errors keep together, so that N is less than their count
};

/// From the gradient and the Gauss-Newton matrix of the arrivals where a fit stands, x, near to what the
/// visit says:
///   N (theta_2 - x) = -g,   so that   N (theta_2 - theta_1) = N (x - theta_1) - g
/// All other parameters are eliminated with what is known of them. Where errors are correlated, by the
/// residuals or because those of the first calibration were, estimates of white weights have the covariance G
/// (P^-1 + M) G with G = (P^-1 + N)^-1, and the visit is worth N M^-1 N (Huber's sandwich turned inside out).
/// @param fit  its states are solved here; with the joint prior of set_joint_prior
/// @param P  covariance of that prior [SI]
/// @param noise  of the first calibration
/// @param known_white  a part of the same recording has shown that errors are white: that is not tested again
[[nodiscard]] VisitInformation visit_information(Fit& fit, const KnownParameters& known,
                                                 const Eigen::MatrixXd& P, const Deployment& noise,
                                                 int threads, bool known_white = false);

/// Covariance of a visit's estimates between the one under the errors that the first calibration stated and
/// the one under those that the visit's residuals show. A short visit tells its errors badly, so that they
/// are not taken to be less than stated: the larger one counts, by the mean of its variances over the white
/// ones. Where these are about equal, within exp(+-1/4), the logarithm of their ratio mixes both, so that the
/// draws behind the model tip no balance.
/// @param white  under white errors; positive diagonal, same size as the others
[[nodiscard]] Eigen::MatrixXd between_error_models(const Eigen::MatrixXd& white,
                                                   const Eigen::MatrixXd& stated,
                                                   const Eigen::MatrixXd& shown);

/// What a Gaussian prior of mean theta_1 becomes by a visit.
struct Updated {
  Eigen::VectorXd step;  ///< from theta_1
  Eigen::MatrixXd covariance;
};
/// (P^-1 + N)^-1, and that times the gradient. @param P  positive definite
[[nodiscard]] Updated updated_by(const Eigen::MatrixXd& P, const Eigen::MatrixXd& N,
                                 const Eigen::VectorXd& gradient);

}  // namespace octant::calib
