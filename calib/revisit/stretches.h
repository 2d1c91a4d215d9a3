// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/run.h"

namespace octant::calib {

/// Short, evenly spread segments of drives as separate recordings with about the given total number of
/// arrivals; other recordings unchanged. Empty if the recordings have at most twice that number.
[[nodiscard]] std::vector<MeasurementLog> evenly_spread_stretches(const std::vector<MeasurementLog>& runs,
                                                                  std::size_t arrivals);

}  // namespace octant::calib
