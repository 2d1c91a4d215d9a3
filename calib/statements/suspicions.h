// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/log_health.h"
#include "models/site.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// An adjusted log, or an evenly spread part of it.
struct Adjusted {
  const Site& site;
  const SharedState& state;
  const std::vector<Trajectory>& trajectories;
  double stride = 1.0;  ///< one of every `stride` stops is included
};

/// Checks the logs by an adjustment: receivers whose ranges fit the position of another receiver (exchanged
/// cables) or no position, and jumps of a clock between stops. Adds the jumps to the health of the runs.
[[nodiscard]] std::vector<Finding> suspicions(const Adjusted& adjusted, std::vector<RunHealth>& runs);

}  // namespace octant::calib
