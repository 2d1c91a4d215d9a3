// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/adjust/estimate.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// A solution of which nothing came but the word that it was stopped.
[[nodiscard]] Solution interrupted_solution();

/// Whether anything fixes the scale: two places that are known, a taped distance, an array or odometry, or
/// the speed itself, to a tenth. Empty if so, otherwise what is missing.
[[nodiscard]] std::optional<WeakDirection> missing_scale(const Problem& problem);

/// Nothing is solved, as the data do not determine a direction; what would settle it is said.
[[nodiscard]] Solution refused(WeakDirection direction);

/// Refused where no pose of the vehicle was found, or, all beacons being held, none for most of the arrivals:
/// what is calibrated then hangs on the few that chance placed. None: enough was found.
/// @param least_share  of the arrivals of held beacons that have to have a pose
[[nodiscard]] std::optional<Solution> without_poses(const Problem& problem, const AdjustedLog& log,
                                                    double least_share);

}  // namespace octant::calib
