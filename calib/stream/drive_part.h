// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/problem/problem.h"
#include "calib/stream/drive_index.h"

namespace octant::calib {

/// A problem with evenly spread stretches of long drives that are not at hand, their odometry row by row and
/// summed up between them, and enough of each beacon: what thin() takes of drives that are.
[[nodiscard]] Result<Problem> part_of(const Site& site, const ArrivalSource& source, const DriveIndex& index,
                                      int threads = 1);

}  // namespace octant::calib
