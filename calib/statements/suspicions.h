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
  double stride = 1.0;  ///< one of so many stops is there
};

/// What an adjustment shows of the logs: receivers whose ranges fit the place of another one (exchanged
/// cables) or no place at all, and jumps of a clock between stops. Jumps are added to the runs' health too.
[[nodiscard]] std::vector<Finding> suspicions(const Adjusted& adjusted, std::vector<RunHealth>& runs);

}  // namespace octant::calib
