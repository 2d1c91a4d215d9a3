// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/fix.h"
#include "models/ids.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Of a segment's arrivals from a beacon, or from all (no beacon), those marked `from` are marked `to`.
/// Returns whether there were any.
bool set_rejections(Trajectory& trajectory, const Segment& segment, BeaconId beacon, Rejection from,
                    Rejection to);

/// Puts the rejections of arrivals [first, last) into a fix, and how many of them are in use.
void report_arrivals(const Trajectory& trajectory, std::size_t first, std::size_t last, Fix& fix);

}  // namespace octant
