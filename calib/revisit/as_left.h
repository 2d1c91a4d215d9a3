// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/problem/problem.h"
#include "calib/revisit/visit_information.h"
#include "calib/statements/refit.h"
#include "models/changes/comparison.h"
#include "models/deployment.h"

namespace octant::calib {

/// The medium during the second visit.
struct MediumFound {
  bool temperature_known = false;  ///< the temperature was recorded, or does not matter
  double temperature_degC = 0.0;   ///< mean of the recordings, otherwise the assumed one
  double speed_change_mps = 0.0;   ///< change of the offset from the medium's model, new minus old
  double speed_change_sigma_mps = 0.0;
};

/// An earlier deployment, updated by a second visit.
struct AsLeft {
  Deployment deployment;
  double speed_change_sigma_mps = 0.0;  ///< sigma of the visit, including the drift
  std::vector<std::string> warnings;    ///< beacons that are not determined any more
};

/// Mean and covariance of the parameters after the visit. A fixed parameter that did not change remains
/// fixed.
/// @param drift  variances
[[nodiscard]] AsLeft as_left(const Deployment& before, const KnownParameters& known,
                             const Eigen::VectorXd& drift, const Comparison& comparison,
                             const VisitInformation& visit, double tolerance_m);

/// Temperature of the recordings: mean, and if each arrival has one.
[[nodiscard]] MediumFound thermometer_of(const Deployment& deployment,
                                         const std::vector<MeasurementLog>& runs);
/// Extends the validity of a deployment by the positions of a visit, and by its temperatures if they are
/// known.
void extend_validity(Deployment& deployment, const std::vector<Trajectory>& trajectories,
                     const Problem& problem, bool temperature_known);

}  // namespace octant::calib
