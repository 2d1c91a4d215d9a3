// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/readings/reading.h"
#include "calib/statements/common_errors.h"

namespace octant::calib {

/// Hypotheses on the scale of odometry: distances (wheel diameter) or turns (wheel distance) too large or too
/// small by 1 % to 50 %. Empty without planar odometry. Site and runs must outlive the result.
[[nodiscard]] std::vector<ReadingFamily> odometry_of_other_scale(const Site& site,
                                                                 const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
