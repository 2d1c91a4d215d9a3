// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/fix.h"
#include "models/ids.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Changes the mark `from` to `to` for a segment's arrivals of one beacon, or of all if the beacon is
/// invalid. Returns true if there were any.
bool set_rejections(Trajectory& trajectory, const Segment& segment, BeaconId beacon, Rejection from,
                    Rejection to);

/// Writes the rejections of arrivals [first, last) and the number of used arrivals into a fix.
void report_arrivals(const Trajectory& trajectory, std::size_t first, std::size_t last, Fix& fix);

}  // namespace octant
