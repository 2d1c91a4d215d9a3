// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/run.h"

namespace octant::calib {

/// How much of a recording a forecast looks at.
struct ThinOptions {
  std::size_t instants = 300;      ///< epochs or distinct times, evenly spread
  std::size_t per_beacon = 40;     ///< arrivals that each beacon keeps, if it has as many
  std::size_t per_pair = 16;       ///< arrivals of one beacon at one receiver within one epoch or stretch
  std::size_t drive_arrivals = 6000;  ///< of all stretches of a drive together, about
  double stretch_s = 3.0;          ///< long against the time over which odometry ties states together
};

/// A smaller recording that tells the same: evenly spread epochs (or stretches of a drive, with their odometry row for row and the
/// odometry between them summed up), and more of them where a beacon would have too little. Measured poses stay where arrivals
/// do. A recording that is small already comes back as it is.
/// @param beacons  number of beacons of the site
[[nodiscard]] MeasurementLog thin(const MeasurementLog& run, std::size_t beacons, const ThinOptions& options = {});

}  // namespace octant::calib
