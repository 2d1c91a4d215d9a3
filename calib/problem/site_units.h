// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::calib {

/// Box around all positions of a site and of a recording's poses; may be empty.
[[nodiscard]] Eigen::AlignedBox3d box_of_places(const Site& site, const std::vector<TimedPose>& poses = {});

/// Largest distance: across that box, or taped; 0 without any.
[[nodiscard]] double stated_extent_m(const Site& site, const std::vector<TimedPose>& poses);
/// A unit of length that people write where metres are expected.
struct LengthUnit {
  const char* name;   ///< "centimetres"
  double metres = 1;  ///< metres of one unit
};
/// Centimetres, millimetres, feet, inches.
[[nodiscard]] const std::vector<LengthUnit>& length_units();

/// Unit in which a position seems to be stated that was estimated elsewhere: its distance from the origin is
/// this factor too large in every direction, to a hundredth and three sigmas. No value if no unit explains
/// it.
[[nodiscard]] std::optional<LengthUnit> unit_of_place(const Eigen::Vector3d& stated,
                                                      const Eigen::Vector3d& found_m, double sigma_m);

/// Beacons whose stated coordinates have another order of magnitude than the others (centimetres among
/// metres) and fit in that unit; may be all false.
[[nodiscard]] std::vector<bool> beacons_in_unit(const Site& site, const LengthUnit& unit);

/// Positions that are scaled in the hypothesis of another unit.
struct ScaledParts {
  std::vector<bool> beacons;  ///< by beacon
  bool receivers = false;
};
/// The site with these positions in another unit. Sigmas are scaled too if they would be large compared with
/// the site.
[[nodiscard]] Site in_unit(const Site& site, const LengthUnit& unit, const ScaledParts& parts);

/// Finds numbers in the site file with which no recording can agree: a delay longer than every time of flight
/// (microseconds instead of seconds). Errors (kBadInput): value, expected value, and the probable unit.
[[nodiscard]] Result<void> check_site_units(const Site& site, const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
