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

/// Margin by which the air may leave the calibrated range of temperatures. The model's slope is good to one
/// percent of 0.6 m/s per degree, so at 5 degrees it adds less error than the sigma of a good calibration
/// (0.03 m/s).
inline constexpr double kTemperatureMargin_degC = 5.0;
/// Margin by which fixes may leave the calibrated area, as a share of its largest extent.
inline constexpr double kAreaMargin = 0.1;

/// Lowest and highest air temperature of a recording, from the run and from its arrivals; no value if it
/// states none.
[[nodiscard]] std::optional<std::array<double, 2>> stated_temperatures(const MeasurementLog& run);

/// Conditions of a recording outside those that its deployment was calibrated for.
struct OutsideValidity {
  bool reference_assumed = false;  ///< the recording states no temperature although the speed depends on it
  std::optional<double> temperature_degC;  ///< temperature farthest outside the calibrated range plus margin
  std::size_t fixes = 0,
              outside = 0;  ///< number of fixes, and of those outside the calibrated area plus margin
  double farthest_m = 0.0;  ///< largest distance of a fix from the calibrated area

  [[nodiscard]] bool any() const { return reference_assumed || temperature_degC || outside > 0; }
};
/// @param fixes  fixes of this run; epochs without a fix are ignored
[[nodiscard]] OutsideValidity outside_validity(const Deployment& deployment, const MeasurementLog& run,
                                               std::span<const Fix> fixes);

/// Date at which the site's validity period ends.
struct CalibrationDue {
  std::int64_t at_s = 0;  ///< seconds since 1970, UTC
  std::string beacon;  ///< first beacon that may have left the tolerance by then; empty if the stated months
                       ///< end first
  [[nodiscard]] bool by_drift() const { return !beacon.empty(); }
};
/// Returns the earlier of two dates: the end of the stated months, and the time at which a beacon may deviate
/// by more than the tolerance (95 % in the plane). The drift counts as a standard deviation that grows
/// linearly: 2.45 sqrt(sigma^2 + (drift t)^2). The date is immediate for a beacon whose calibration already
/// exceeds the tolerance; control points drift like other beacons. A month has 30.44 days.
/// @return no value if neither limit is given, or if `created` is not a date
[[nodiscard]] std::optional<CalibrationDue> calibration_due(const Deployment& deployment);

/// Distance of a position from the calibrated area and, in space, from the calibrated heights [m]; 0 inside.
[[nodiscard]] double distance_from_validity_m(const Deployment& deployment, const Eigen::Vector3d& p_map_m);

/// Distance of a point from an area like Deployment::validity_area_m (which may degenerate to a line or a
/// point) [m]; 0 inside.
[[nodiscard]] double distance_from_area_m(const std::vector<Eigen::Vector2d>& area_m,
                                          const Eigen::Vector2d& point_m);

}  // namespace octant
