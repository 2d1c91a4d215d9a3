// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/adjust/estimate.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// A solution that was cancelled.
[[nodiscard]] Solution interrupted_solution();

/// Checks that the scale is determined: two known positions, a taped distance, an array or odometry, or the
/// speed itself, to a tenth. Returns an empty text, or what is missing.
[[nodiscard]] std::optional<WeakDirection> missing_scale(const Problem& problem);

/// A solution for data that do not determine a direction, with the remedy.
[[nodiscard]] Solution refused(WeakDirection direction);

/// Refusal if no pose of the vehicle was found, or, with all beacons fixed, no pose for most of the arrivals:
/// the result would then depend on a few accidental ones. No value if enough were found.
/// @param least_share  fraction of the arrivals of fixed beacons that must have a pose
[[nodiscard]] std::optional<Solution> without_poses(const Problem& problem, const AdjustedLog& log,
                                                    double least_share);

}  // namespace octant::calib
