// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/deployment.h"
#include "models/run.h"

namespace octant::app {

/// Why arrivals may give no fix at all, a sentence each: tof_s in another unit than seconds (as calibrate and
/// monitor judge it); rows without an epoch of which no two beacons' come together; one epoch for all.
/// @param rows          of a recording, or the first ones of a stream
/// @param pose_by_pose  each pose hangs on its own arrivals: epochs matter
[[nodiscard]] std::vector<std::string> doubts_about(const Deployment& deployment, const MeasurementLog& rows,
                                                    bool pose_by_pose);

}  // namespace octant::app
