// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/readings/reading.h"
#include "calib/statements/common_errors.h"

namespace octant::calib {

/// Odometry whose way is too long or too short (wheels of another diameter), or whose turns are (wheels
/// farther apart), by one part in a hundred to a half; none where there is none, or it is in space. The site
/// and the runs outlive it.
[[nodiscard]] std::vector<ReadingFamily> odometry_of_other_scale(const Site& site,
                                                                 const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
