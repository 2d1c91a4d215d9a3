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

/// The medium as the second visit found it.
struct MediumFound {
  bool temperature_known = false;  ///< a thermometer was read, or temperature does not matter
  double temperature_degC = 0.0;   ///< mean of what the recordings say, else what was assumed
  double speed_change_mps = 0.0;   ///< of the offset from the medium's model, new less old
  double speed_change_sigma_mps = 0.0;
};

/// An earlier deployment, updated by what a second visit says.
struct AsLeft {
  Deployment deployment;
  double speed_change_sigma_mps = 0.0;  ///< of what the visit adds: its own, and the drift's
  std::vector<std::string> warnings;    ///< beacons that are not determined any more
};

/// Mean and covariance of the parameters after the visit; what was held and did not change stays held.
/// @param drift  variances
[[nodiscard]] AsLeft as_left(const Deployment& before, const KnownParameters& known,
                             const Eigen::VectorXd& drift, const Comparison& comparison,
                             const VisitInformation& visit, double tolerance_m);

/// The thermometer of the recordings: whether each arrival has a temperature, and their mean.
[[nodiscard]] MediumFound thermometer_of(const Deployment& deployment,
                                         const std::vector<MeasurementLog>& runs);
/// What a deployment is valid for, by a visit's places and (where they are known) its temperatures too.
void extend_validity(Deployment& deployment, const std::vector<Trajectory>& trajectories,
                     const Problem& problem, bool temperature_known);

}  // namespace octant::calib
