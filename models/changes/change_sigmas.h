// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/change.h"
#include "models/parameter.h"
#include "models/site.h"

namespace octant {

/// Standard deviations of changes for each kind of parameter that may change.
struct ChangeSigmas {
  double beacon_m = 0.0;  ///< each axis
  double delay_s = 0.0;
  double receiver_m = 0.0;  ///< each axis
  double speed_mps = 0.0;
  double log_gain = 0.0;

  /// Returns 0 for parameters that are not tested for changes.
  [[nodiscard]] double of(const ParameterId& parameter) const;
};

/// Kinds of media, which differ in noise and in the range that corresponds to a delay.
enum class MediumKind { kAir, kWater, kRadio };
[[nodiscard]] MediumKind medium_kind(double speed_mps);

/// Typical size of a change, as when something is moved or replaced.
[[nodiscard]] ChangeSigmas usual_changes(double speed_mps);
/// Prior of a parameter that is known to have changed, independent of its earlier value.
[[nodiscard]] ChangeSigmas released_sigmas(double speed_mps);

/// Drift between two visits, months apart: in quadrature, the differences between two visits on one day and a
/// part that grows with time, such as settling and ageing. Both depend on the kind of medium. Delays drift by
/// a range, which the speed of the medium converts to a time.
///
/// | kind  | beacon, delay, receiver, speed at once | a year                      |
/// |-------|----------------------------------------|-----------------------------|
/// | air   | 1, 1, 0.5 mm, 0.3 m/s                  | 1.2, 1.2, 0.6 mm, 0.36 m/s  |
/// | water | 20, 10, 5 mm, 0.5 m/s                  | 100, 20, 5 mm, 0.5 m/s      |
/// | radio | 5, 20, 2 mm, 0.3 m/s                   | 5, 30, 2 mm, 0.36 m/s       |
///
/// @param rates  replace the values of a year
/// @param speed_mps  speed of the medium, which determines its kind
[[nodiscard]] Drift drift_after(double months, const DriftRates& rates, double speed_mps);

}  // namespace octant
