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

/// From a fit under a joint prior (covariance P), which is taken out again:
///   P^-1 (x - theta_1) = N (theta_2 - x),   so that   N (theta_2 - theta_1) = P^-1 (x - theta_1) + N (x -
///   theta_1)
/// All other parameters are eliminated with what is known of them. Where errors are correlated, by the
/// residuals or because those of the first calibration were, estimates of white weights have the covariance G
/// (P^-1 + M) G with G = (P^-1 + N)^-1, and the visit is worth N M^-1 N (Huber's sandwich turned inside out).
/// @param fit  settled, with the joint prior of set_joint_prior
/// @param P  covariance of that prior [SI]
/// @param noise  of the first calibration
[[nodiscard]] VisitInformation visit_information(const Fit& fit, const KnownParameters& known,
                                                 const Eigen::MatrixXd& P, const Deployment& noise,
                                                 int threads);

}  // namespace octant::calib
