// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "models/deployment.h"
#include "models/run.h"

namespace octant {

/// An arrival reduced to a distance, with how the distance hangs on what it was reduced by.
struct ArrivalRange {
  double range_m =
      std::numeric_limits<double>::quiet_NaN();  ///< one way, slant; NaN: tof_s gives no distance
  double sigma_m = 0.0;    ///< of the time's noise, and of the amplitude's where it was used
  double speed_mps = 0.0;  ///< at the arrival's temperature, else at the deployment's
  double gain_mps = 0.0;   ///< range per second of time of flight; minus this per second of delay
  /// Range per m/s of speed [s].
  [[nodiscard]] double by_speed_s() const { return gain_mps * range_m / (speed_mps * speed_mps); }
};

/// Distance of a calibrated arrival (Thamma eq. 3-5; Chang eq. 1-3):
///   d = c(temperature) (T - beacon delay - receiver delay - walk),   two-way: half of that, turnaround taken
///   off
/// Time-walk is that of the measured amplitude where one above the threshold was logged, else that of the
/// amplitude predicted at the distance, which makes the equation implicit; it has one solution, found to
/// rounding. Allocates nothing.
[[nodiscard]] ArrivalRange arrival_range(const Arrival& arrival, const Deployment& deployment) noexcept;

}  // namespace octant
