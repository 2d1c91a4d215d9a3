// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/run.h"

namespace octant::calib {

/// Whether the vehicle moves, by its measured poses, while something is heard, so that their clock matters.
[[nodiscard]] bool poses_are_of_motion(const MeasurementLog& run);

/// Share of the arrivals at whose time there is a measured pose, with the poses' stamps so late: a lag that
/// takes poses away explains nothing.
[[nodiscard]] double share_with_pose(const MeasurementLog& run, double lag_s);

/// Poses as a clock would have stamped them that runs with the arrivals'.
/// @param lag_s  by which the poses' stamps are late; negative: early
void take_back_lag(double lag_s, MeasurementLog& run);

}  // namespace octant::calib
