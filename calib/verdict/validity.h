// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Where vehicles were, and how warm it was when something was heard.
struct LogExtent {
  std::vector<Eigen::Vector2d> places_m;
  double coldest_degC = INFINITY, hottest_degC = -INFINITY;
  /// @param run  the trajectory's
  void add(const Trajectory& trajectory, const MeasurementLog& run, const Site& site);
};

}  // namespace octant::calib
