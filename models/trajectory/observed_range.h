// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "models/trajectory/trajectory.h"

namespace octant {

/// One-way range that explains an arrival's time of flight, given the shared state and its time-walk [m]. Not
/// positive if the time is shorter than the delays.
/// @param cycle_offset_s  offset of the arrival's epoch. If unknown, offset and walk remain in the range,
/// because the amplitude cannot be predicted.
[[nodiscard]] double observed_range_m(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                      const SharedState& state,
                                      std::optional<double> cycle_offset_s = std::nullopt);

}  // namespace octant
