// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "calib/sums/ranks.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

struct AdjustOptions {
  RobustLoss loss;
  int max_iterations = 100;
  Workers workers;
  double function_tolerance = 1e-10;
  std::function<bool(int iteration, double cost)> on_iteration;  ///< false stops
};

}  // namespace octant::calib
