// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/site_units.h"
#include "models/run.h"

namespace octant::calib {

/// Assignments of beacons to two groups: positions in `unit` and positions in metres. The difference of two
/// ranges from one place is at most the distance of their beacons, and their sum is at least that distance.
/// This brackets each distance. The result has the assignment that violates the brackets least, and variants
/// of it for beacons that the brackets do not determine, such as those near the origin. Empty if it is not
/// far better than metres for all, or if all beacons have the other unit.
[[nodiscard]] std::vector<std::vector<bool>> beacons_in_unit_by_ranges(
    const Site& site, const std::vector<MeasurementLog>& runs, const LengthUnit& unit);

/// Returns true if the brackets are violated far less with the positions of all beacons in `unit`.
[[nodiscard]] bool are_all_in_unit_by_ranges(const Site& site, const std::vector<MeasurementLog>& runs,
                                             const LengthUnit& unit);

}  // namespace octant::calib
