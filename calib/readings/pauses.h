// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/run.h"

namespace octant::calib {

/// Numbers the stops of a recording by the pauses between its arrivals: gaps several times longer than those
/// between the arrivals of a stop. Only where nothing else tells how the vehicle moved (no epochs, or one for
/// all; no odometry, no measured poses).
/// @return  number of stops, now numbered; 0: the recording has other motion, or no such pauses, and is left
/// as it was
std::size_t number_stops(MeasurementLog& run);

}  // namespace octant::calib
