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

/// Of the errors of arrivals that the residuals show (common_errors.h) the clearest: a medium that changes, a
/// clock that drifts or jumps. The site and the runs outlive it.
[[nodiscard]] std::vector<ReadingFamily> with_common_errors(const std::vector<CommonError>& errors,
                                                            const Site& site,
                                                            const std::vector<MeasurementLog>& runs);
/// Of measured poses that shift (common_errors.h); none where none do.
[[nodiscard]] std::vector<ReadingFamily> poses_that_shift(const std::vector<CommonError>& errors,
                                                          const Site& site,
                                                          const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
