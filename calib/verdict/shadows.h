// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/statements/score_test.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// What beacons that were shadowed at a stop, unseen, may have done to an adjustment.
struct ShadowRisk {
  Eigen::MatrixXd covariance;  ///< beside that of the noise, internal units; empty: none
  double share = 0.0;          ///< of beacons at stops that are late at all receivers, of those heard
};

/// A beacon that something stands before is heard late by all receivers of a stop. Where few others are heard
/// there, stop and beacon give way, and no residual is an outlier: the estimate is that of one hypothesis
/// among several. Each beacon in use at each stop has another one, that it is late. With b its lateness and
/// w = b / sigma_b by the score (score_test.h), their odds are
///   share / (1 - share) * sqrt(2 pi) sigma_b / range * exp(w^2 / 2) Phi(w)
/// for a lateness that is as likely anywhere from none to `range`, twice the median of those that were left
/// out; and where it is late, the parameters are off by -C J'c b. Over both hypotheses the second moment
/// about the estimate grows by P (C J'c)(C J'c)' E[b^2] (model averaging: Hoeting, Madigan, Raftery and
/// Volinsky 1999). Nothing where no beacon was late at a stop, and of drives.
/// @param parameters  of all that the trajectories hold
[[nodiscard]] ShadowRisk shadow_risk(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                     const AdjustedParameters& parameters);

}  // namespace octant::calib
