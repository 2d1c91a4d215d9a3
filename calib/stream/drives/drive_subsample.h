// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/stream/drives/drive_index.h"

namespace octant::calib {

/// Evenly spread stretches of a run that is not at hand and not of stops alone, their odometry row by row and
/// summed up between them, and enough of each beacon: what subsample() takes of drives that are.
[[nodiscard]] Result<MeasurementLog> subsample_of_drives(std::size_t run, const Site& site,
                                                         const ArrivalSource& source,
                                                         const DriveIndex& index);

}  // namespace octant::calib
