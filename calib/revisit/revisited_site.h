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

/// Variances of changes of common size [SI], which prevent arrivals of a changed beacon from being rejected
/// before the change is known; 0 for parameters whose changes are not searched.
[[nodiscard]] Eigen::VectorXd room_for_change(const KnownParameters& known);

/// Site for a second visit: all parameters of the earlier calibration are free, also control points, each
/// with its own variance as a prior. Beacons that were undetermined have no prior.
/// @param variance  of each known parameter [SI]
[[nodiscard]] Site revisited_site(const Deployment& deployment, const KnownParameters& known,
                                  const Eigen::VectorXd& variance);

/// Columns of the known parameters in a layout of that site; -1 for fixed ones.
[[nodiscard]] std::vector<int> columns_of(const ParameterLayout& layout, const KnownParameters& known);

/// Replaces the separate priors of the known parameters by their joint prior.
/// @param covariance  [SI], positive definite
void set_joint_prior(ParameterLayout& layout, const KnownParameters& known,
                     const Eigen::MatrixXd& covariance);

}  // namespace octant::calib
