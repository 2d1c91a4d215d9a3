// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "models/trajectory/trajectory.h"

namespace octant {

/// Distance, one way, at which an arrival's time of flight is explained by what a state knows, time-walk
/// included. [m], not positive where the time is shorter than its delays.
/// @param cycle_offset_s  of the arrival's epoch; unknown: it stays in the range, and so does the walk, as no
/// amplitude can be predicted
[[nodiscard]] double observed_range_m(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                      const SharedState& state,
                                      std::optional<double> cycle_offset_s = std::nullopt);

}  // namespace octant
