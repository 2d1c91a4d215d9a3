// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/site_units.h"
#include "models/run.h"

namespace octant::calib {

/// Ways to share out the beacons among those whose positions the ranges put in a unit and those in metres:
/// two ranges from one place differ by no more than their beacons' distance and add up to no less, which
/// brackets each distance. The share that breaks the least, and it with beacons in or out that the brackets
/// do not tell, as near the origin. None where that is not far better than metres for all, or is the unit for
/// all.
[[nodiscard]] std::vector<std::vector<bool>> beacons_in_unit_by_ranges(
    const Site& site, const std::vector<MeasurementLog>& runs, const LengthUnit& unit);

}  // namespace octant::calib
