// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/run.h"

namespace octant {

/// Arrivals of one moment: of one time, or heard while the vehicle, whose pose was measured, moved by less
/// than a tenth of what that pose is good to, and of the noise of a range. As states of their own each would
/// have the one error of the pose anew.
/// @param arrivals  indices into the log's, by time  @param first  of them, heard at T
/// @param T  where it was measured to be then; none: arrivals of one time alone
/// @param noise_m  of a range
/// @return behind the last of them
[[nodiscard]] std::size_t end_of_moment(const MeasurementLog& log, const std::vector<std::size_t>& arrivals,
                                        std::size_t first, const Pose* T, double noise_m);

}  // namespace octant
