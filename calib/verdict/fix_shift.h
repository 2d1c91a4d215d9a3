// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/parameters.h"

namespace octant::calib {

/// How far typical fixes are off when the shared parameters are y instead of x [m, RMS over places]: at some
/// thirty of the states, a vehicle that stands there hears the beacons in reach over the paths of the log,
/// and sees those whose bearings the log has, as x predicts it, and is located by y from that alone.
/// Displacement of its origin in the plane, and by its heading of the receiver farthest from the origin;
/// nothing else of the log takes part, so that measured poses hide no shift. Empty where no stop hears enough
/// beacons.
[[nodiscard]] std::optional<double> fix_shift_m(const ParameterLayout& layout, const Eigen::VectorXd& x,
                                                const Eigen::VectorXd& y,
                                                const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
