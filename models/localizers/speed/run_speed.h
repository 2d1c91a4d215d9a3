// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include "models/deployment.h"
#include "models/run.h"

namespace octant {

/// Difference in sigmas above which the speed counts as different from that of the deployment.
inline constexpr double kSpeedDiffersBy = 3.0;

/// Speed in a recording at an unknown temperature, estimated from redundant arrivals.
struct RunSpeed {
  bool determined = false;  ///< false: the arrivals do not determine the speed, and only the counts are valid
  double offset_mps =
      0.0;  ///< difference from the deployment's speed at the stated (or reference) temperature
  double sigma_mps = 0.0;  ///< sigma of the offset, including that of the calibrated speed
  double temperature_degC =
      0.0;  ///< air temperature that corresponds to the speed; without one, its sigma is 0
  double temperature_sigma_degC = 0.0;  ///< from the medium's model
  std::size_t poses = 0, arrivals = 0;  ///< used for the estimate

  /// True if the speed is determined and differs from the deployment's; happens by chance once in 370 runs.
  [[nodiscard]] bool differs() const {
    return determined && std::abs(offset_mps) > kSpeedDiffersBy * sigma_mps;
  }
};

/// An offset counts as determined if its sigma is at most this share of the speed: three metres per second,
/// or five degrees in air.
inline constexpr double kSpeedKnownTo = 0.01;

/// Returns true if the deployment does not cover the temperature of a run: the speed depends on it, and the
/// recording states none or one outside the validity.
[[nodiscard]] bool speed_is_unknown(const Deployment& deployment, const MeasurementLog& run);

/// Estimates one speed offset for a whole run. Poses are first found with an allowance for a wrong speed in
/// every range. All poses are then solved at several speeds, and the parabola through their sums of squares,
/// the profile likelihood, yields the offset. This is repeated with decreasing allowance under Cauchy's loss,
/// and finally with the squared loss of the arrivals that agree. Uses about sixty stops, or the first three
/// thousand arrivals of a drive.
[[nodiscard]] RunSpeed estimate_run_speed(const Deployment& deployment, const MeasurementLog& run);

/// The deployment with this speed and its sigma, which is then independent of the beacons' errors.
[[nodiscard]] Deployment at_speed(Deployment deployment, const RunSpeed& speed);

}  // namespace octant
