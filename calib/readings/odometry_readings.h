// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/readings/reading.h"
#include "models/contradiction.h"

namespace octant::calib {

/// First run with planar odometry; no value if there is none.
[[nodiscard]] std::optional<std::size_t> run_of_planar_odometry(const std::vector<MeasurementLog>& runs);
/// Hypotheses that turns or distances of the odometry have the wrong sign, or are in degrees, centimetres or
/// millimetres. Empty without planar odometry.
[[nodiscard]] std::vector<Reading> other_odometry(const std::vector<MeasurementLog>& runs);
/// Hypotheses on a time lag of the odometry. Empty without planar odometry.
[[nodiscard]] std::vector<ReadingFamily> odometry_stamped_late(const std::vector<MeasurementLog>& runs);

/// Joins receivers rotated by 180 degrees with reversed odometry, which are equivalent. The site file is
/// wrong more often.
void join_odometry_to_wiring(std::vector<Contradiction>& reported);

}  // namespace octant::calib
