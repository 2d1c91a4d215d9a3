// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/run.h"

namespace octant {

/// A calibrated speed is used this far beyond the temperatures at which it was calibrated: there the model's
/// slope, good to a percent of 0.6 m/s a degree, is off by less than the sigma of a good calibration (0.03
/// m/s).
inline constexpr double kTemperatureMargin_degC = 5.0;
/// Fixes are used this far outside the calibrated area, as a share of its largest extent.
inline constexpr double kAreaMargin = 0.1;

/// Coldest and warmest air that a recording states, its own and its arrivals'; none where it states none.
[[nodiscard]] std::optional<std::array<double, 2>> stated_temperatures(const MeasurementLog& run);

/// Where a recording leaves what its deployment was calibrated for.
struct OutsideValidity {
  bool reference_assumed = false;  ///< the recording states no temperature, and the speed depends on it
  std::optional<double> temperature_degC;  ///< the one farthest outside the calibrated range and its margin
  std::size_t fixes = 0, outside = 0;      ///< of the run; of these beyond the calibrated area and its margin
  double farthest_m = 0.0;  ///< largest distance of a fix from the calibrated area, margin included

  [[nodiscard]] bool any() const { return reference_assumed || temperature_degC || outside > 0; }
};
/// @param fixes  of this run; those that are none do not count
[[nodiscard]] OutsideValidity outside_validity(const Deployment& deployment, const MeasurementLog& run,
                                               std::span<const Fix> fixes);

/// When a recalibration is due by the validity that the site states.
struct CalibrationDue {
  std::int64_t at_s = 0;  ///< since 1970, UTC
  std::string
      beacon;  ///< the first that may have left the tolerance by then; empty: the stated months are over
  [[nodiscard]] bool by_drift() const { return !beacon.empty(); }
};
/// The earlier of the stated months, and the time at which some beacon may be off by more than the tolerance
/// (95 % in the plane), its drift standing for a standard deviation that grows with time beside that of the
/// calibration: 2.45 sqrt(sigma^2 + (drift t)^2). At once where it is not known that well to begin with;
/// control points settle as others do. None where neither is stated, or `created` is no date. Months
/// have 30.44 days.
[[nodiscard]] std::optional<CalibrationDue> calibration_due(const Deployment& deployment);

/// Distance of a point from an area as Deployment::validity_area_m (a line or a point may stand for it); 0
/// within [m].
[[nodiscard]] double distance_from_area_m(const std::vector<Eigen::Vector2d>& area_m,
                                          const Eigen::Vector2d& point_m);

}  // namespace octant
