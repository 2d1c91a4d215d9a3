// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "models/deployment.h"
#include "models/run.h"

namespace octant {

/// Range of an arrival, with its derivatives by the quantities that it was computed from.
struct ArrivalRange {
  double range_m =
      std::numeric_limits<double>::quiet_NaN();  ///< one-way slant range; NaN: tof_s gives no range
  double sigma_m = 0.0;    ///< noise of the time, and of the amplitude where it was used
  double speed_mps = 0.0;  ///< speed at the temperature of the arrival, else of the deployment
  double gain_mps = 0.0;   ///< derivative by the time of flight; that by a delay has the opposite sign
  /// Derivative by the speed [s].
  [[nodiscard]] double by_speed_s() const { return gain_mps * range_m / (speed_mps * speed_mps); }
};

/// Range of an arrival from calibrated values (Thamma eq. 3-5; Chang eq. 1-3):
///   d = c(temperature) (T - beacon delay - receiver delay - walk)
/// With two-way ranging the turnaround time is subtracted and the result halved. The time-walk follows from
/// the measured amplitude if one above the threshold was logged. Otherwise it follows from the amplitude
/// predicted at d, and the implicit equation is solved to rounding; its solution is unique. Does not
/// allocate.
[[nodiscard]] ArrivalRange arrival_range(const Arrival& arrival, const Deployment& deployment) noexcept;

}  // namespace octant
