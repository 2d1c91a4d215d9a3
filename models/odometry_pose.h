// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/ids.h"
#include "models/physics/pose.h"

namespace octant {

/// The vehicle's pose in the frame of its odometry, which drifts over the map.
struct OdometryPose {
  double time_s = 0.0;
  Pose T_odometry_vehicle;
  VehicleId vehicle;
};

}  // namespace octant
