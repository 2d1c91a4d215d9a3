// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/readings/reading.h"
#include "models/run.h"

namespace octant::calib {

/// Numbers the stops of a recording by pauses: gaps several times longer than those between the arrivals of a
/// stop. Only for recordings without other information on the motion (no epochs, or one for all; no odometry,
/// no measured poses).
/// @return number of stops, now numbered; 0 if the recording is unchanged, because its motion is known or it
/// has no such pauses
std::size_t number_stops(MeasurementLog& run);
/// Hypotheses that stops without epochs, or with one epoch for all, are separated by pauses. Empty without
/// pauses.
[[nodiscard]] std::vector<Reading> numbered_stops(const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
