// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/run.h"

namespace octant::calib {

/// Short stretches of drives, evenly spread over each, as recordings of their own that together hold about so
/// many arrivals; other recordings as they are. Empty where all hold no more than twice that.
[[nodiscard]] std::vector<MeasurementLog> evenly_spread_stretches(const std::vector<MeasurementLog>& runs,
                                                                  std::size_t arrivals);

}  // namespace octant::calib
