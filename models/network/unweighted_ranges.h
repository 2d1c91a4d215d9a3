// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/network/beacon_ranges.h"

namespace octant {

/// Ranges of beacon_ranges() without `root`, which takes minutes for thousands of ranges.
[[nodiscard]] BeaconRanges unweighted_ranges(const Site& site, const std::vector<BeaconFlight>& flights,
                                             const std::vector<MeasurementLog>& runs = {});

}  // namespace octant
