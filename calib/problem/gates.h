// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Marks arrivals that cannot be direct before the vehicle's poses are known: Chang's two range rules
/// (Site::gates), and Kleeman's triangle inequality (eq. 5-6) between arrivals of one epoch at one receiver,
/// for beacons with sufficiently known positions. Tolerances include noise, delays, speed and positions at
/// four sigmas. A mark is not final: an arrival that agrees with the final adjustment is used
/// (reject_outliers).
void apply_gates(const Site& site, std::vector<Trajectory>& trajectories, int threads = 1);

/// Returns true if a gate made the rejection, which stays until the residual shows otherwise.
[[nodiscard]] constexpr bool is_gated(Rejection rejection) {
  return rejection == Rejection::kTriangle || rejection == Rejection::kOutOfRange ||
         rejection == Rejection::kReflection;
}

}  // namespace octant::calib
