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

/// Box round all places that a site and a recording's poses state; empty where they state none.
[[nodiscard]] Eigen::AlignedBox3d box_of_places(const Site& site, const std::vector<TimedPose>& poses = {});

/// Largest distance that they speak of: across that box, or taped; 0 where they speak of none.
[[nodiscard]] double stated_extent_m(const Site& site, const std::vector<TimedPose>& poses);
/// A unit of length that people write where metres are expected.
struct LengthUnit {
  const char* name;   ///< "centimetres"
  double metres = 1;  ///< of one of it
};
/// Centimetres, millimetres, feet, inches.
[[nodiscard]] const std::vector<LengthUnit>& length_units();

/// The unit in which a place seems to be stated that is found elsewhere: its distance from the origin is that
/// many times too large in every direction, to a hundredth and three sigmas. None where no unit explains it.
[[nodiscard]] std::optional<LengthUnit> unit_of_place(const Eigen::Vector3d& stated,
                                                      const Eigen::Vector3d& found_m, double sigma_m);

/// Beacons whose stated coordinates are of another order of magnitude than the others', as centimetres among
/// metres are, and back among them when read in that unit; all false where there are none.
[[nodiscard]] std::vector<bool> beacons_in_unit(const Site& site, const LengthUnit& unit);

/// What is scaled when a site is read in another unit.
struct ScaledParts {
  std::vector<bool> beacons;  ///< by beacon
  bool receivers = false;
};
/// The site with these positions read in a unit. Sigmas are read in it too where they would be large beside
/// the site.
[[nodiscard]] Site in_unit(const Site& site, const LengthUnit& unit, const ScaledParts& parts);

/// Numbers of the site file that no recording can agree with: a delay longer than every time of flight
/// (microseconds for seconds). Errors (kBadInput): value, what it should be, the unit it looks like.
[[nodiscard]] Result<void> check_site_units(const Site& site, const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
