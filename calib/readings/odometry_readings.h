// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/readings/reading.h"

namespace octant::calib {

/// The first run that has odometry; none where it is in space.
[[nodiscard]] std::optional<std::size_t> run_of_planar_odometry(const std::vector<MeasurementLog>& runs);
/// Odometry with the turns or the way of another sign, in degrees, centimetres or millimetres; none where
/// there is none, or it is in space.
[[nodiscard]] std::vector<Reading> other_odometry(const std::vector<MeasurementLog>& runs);
/// Odometry that is stamped late or early; none where there is none, or it is in space.
[[nodiscard]] std::vector<ReadingFamily> odometry_stamped_late(const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
