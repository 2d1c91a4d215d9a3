// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/stream/drives/drive_index.h"

namespace octant::calib {

/// Evenly spaced segments of a run that is not in memory and does not consist of stops only, with their
/// odometry row by row, summed odometry between them, and enough arrivals of each beacon; the equivalent of
/// subsample() for runs in memory.
[[nodiscard]] Result<MeasurementLog> subsample_of_drives(std::size_t run, const Site& site,
                                                         const ArrivalSource& source,
                                                         const DriveIndex& index);

}  // namespace octant::calib
