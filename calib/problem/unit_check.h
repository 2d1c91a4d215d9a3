// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/finding.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::calib {

/// Range of an arrival by the site's medium, prior delay and ranging [m]; no time-walk, cycle offsets left
/// in.
[[nodiscard]] double stated_range_m(const Site& site, const MeasurementLog& run, const Arrival& arrival);

/// Suspected units of tof_s: milliseconds, microseconds, nanoseconds or metres instead of seconds, from the
/// median range and the site's extent; and two-way times interpreted as one-way times, or the reverse, from
/// the triangle inequality between pairs of beacons with known positions.
[[nodiscard]] std::vector<Finding> check_units(const Site& site, const MeasurementLog& run);

}  // namespace octant::calib
