// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include "models/deployment.h"
#include "models/run.h"

namespace octant {

/// Sigmas beyond which the speed is taken to be another one than the deployment's.
inline constexpr double kSpeedDiffersBy = 3.0;

/// The speed of a recording at an unknown temperature, by its redundant arrivals.
struct RunSpeed {
  bool determined = false;  ///< false: the arrivals do not tell; nothing but the counts says anything then
  double offset_mps = 0.0;  ///< of the speed from what the deployment says at the same (or its reference)
                            ///< temperature
  double sigma_mps = 0.0;   ///< of the offset, the calibration's own sigma of the speed included
  double temperature_degC = 0.0;        ///< air of that speed, where there is such air (else its sigma is 0)
  double temperature_sigma_degC = 0.0;  ///< by the medium's model
  std::size_t poses = 0, arrivals = 0;  ///< that it was told from

  /// Determined, and not the deployment's: chance would make so much once in 370 runs.
  [[nodiscard]] bool differs() const {
    return determined && std::abs(offset_mps) > kSpeedDiffersBy * sigma_mps;
  }
};

/// An offset is determined where its sigma is at most this share of the speed: three metres a second in air,
/// five degrees.
inline constexpr double kSpeedKnownTo = 0.01;

/// Whether a run is at a temperature of which its deployment knows nothing: the speed depends on it, and the
/// recording states none, or one outside the validity.
[[nodiscard]] bool speed_is_unknown(const Deployment& deployment, const MeasurementLog& run);

/// One offset of the speed for a whole run. Poses are placed with room for a wrong speed in every range, all
/// are solved at some speeds, and the parabola through their squares (the profile of the likelihood) tells
/// the offset; this is repeated with less and less room and under Cauchy's loss, at last by plain squares of
/// the arrivals that agree. Some sixty stops, or the first three thousand arrivals of a drive.
[[nodiscard]] RunSpeed estimate_run_speed(const Deployment& deployment, const MeasurementLog& run);

/// The deployment with that speed and its sigma, which no longer hangs together with the beacons' errors.
[[nodiscard]] Deployment at_speed(Deployment deployment, const RunSpeed& speed);

}  // namespace octant
