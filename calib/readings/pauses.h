// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/readings/reading.h"
#include "models/run.h"

namespace octant::calib {

/// Numbers the stops of a recording by the pauses between its arrivals: gaps several times longer than those
/// between the arrivals of a stop. Only where nothing else tells how the vehicle moved (no epochs, or one for
/// all; no odometry, no measured poses).
/// @return  number of stops, now numbered; 0: the recording has other motion, or no such pauses, and is left
/// as it was
std::size_t number_stops(MeasurementLog& run);
/// Stops that no epoch column tells apart, or all under one number, numbered so; none where there are none.
[[nodiscard]] std::vector<Reading> numbered_stops(const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
