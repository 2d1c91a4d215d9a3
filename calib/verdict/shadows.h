// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/statements/score_test.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Possible effect of shadowed beacons at stops that no residual shows.
struct ShadowRisk {
  /// In addition to that of the noise, internal units; empty if there is no effect
  Eigen::MatrixXd covariance;
  /// Share of late beacons (late at all receivers of a stop) among those received at stops
  double share = 0.0;
};

/// An obstacle makes a beacon late at all receivers of a stop. If the stop receives few others, its pose and
/// the beacon adapt, and no residual is an outlier: the estimate is that of one hypothesis among several. For
/// each beacon in use at a stop, the alternative is that it is late by b. With w = b / sigma_b from the score
/// test (score_test.h), the odds are
///   share / (1 - share) * sqrt(2 pi) sigma_b / range * exp(w^2 / 2) Phi(w)
/// for a lateness uniform between 0 and `range`, which is twice the median of the rejected ones. A late
/// beacon moves the parameters by -C J'c b. Averaged over both hypotheses (Hoeting, Madigan, Raftery and
/// Volinsky 1999), the second moment about the estimate grows by P (C J'c)(C J'c)' E[b^2]. Without effect if
/// no beacon was late at a stop, and for drives.
/// @param parameters  from all of the trajectories
[[nodiscard]] ShadowRisk shadow_risk(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                     const AdjustedParameters& parameters);

}  // namespace octant::calib
