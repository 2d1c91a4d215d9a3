// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/parameters.h"

namespace octant::calib {

/// Root-mean-square error of typical fixes if the shared parameters are y instead of x [m].
///
/// At about thirty states of the log, a standing vehicle receives the beacons in reach over the paths of the
/// log, and observes those with bearings, as predicted by x. It is located by y from these observations
/// alone; measured poses take no part, as they would hide a shift. The error is the horizontal shift of the
/// origin, and the effect of its heading on the receiver farthest from the origin. No value if no stop
/// receives enough beacons.
[[nodiscard]] std::optional<double> fix_shift_m(const ParameterLayout& layout, const Eigen::VectorXd& x,
                                                const Eigen::VectorXd& y,
                                                const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
