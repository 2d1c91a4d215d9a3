// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/readings/reading.h"

namespace octant::calib {

/// Positions written in another frame than that of a vehicle (x forward, y left) or of a map (x, y as seen
/// from above): the receivers with a coordinate of the wrong sign or x and y exchanged, which turns or
/// mirrors them; the beacons mirrored. What changes nothing is left out. Where no pose and no odometry tells
/// left from right, a mirrored map and mirrored receivers are one and the same to the ranges.
[[nodiscard]] std::vector<Reading> other_site_frames(const Site& site);

}  // namespace octant::calib
