// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/problem/parameters.h"
#include "models/changes/known_parameters.h"
#include "models/deployment.h"
#include "models/site.h"

namespace octant::calib {

/// Variances of changes of a usual size [SI], which keep arrivals of what changed from being rejected as
/// outliers before the change is known; 0 for parameters of which no change is looked for.
[[nodiscard]] Eigen::VectorXd room_for_change(const KnownParameters& known);

/// The site as an earlier calibration left it, for a second visit: everything that it knows is free, control
/// points too, each with its own variance as a prior. Beacons that it did not determine have none.
/// @param variance  of each known parameter [SI]
[[nodiscard]] Site revisited_site(const Deployment& deployment, const KnownParameters& known,
                                  const Eigen::VectorXd& variance);

/// Columns of the known parameters in a layout of that site, -1: held there.
[[nodiscard]] std::vector<int> columns_of(const ParameterLayout& layout, const KnownParameters& known);

/// Puts what is known of the parameters together in the place of what is known of each. @param covariance
/// [SI], positive definite
void set_joint_prior(ParameterLayout& layout, const KnownParameters& known,
                     const Eigen::MatrixXd& covariance);

}  // namespace octant::calib
