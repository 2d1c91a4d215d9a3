// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace octant::calib {

/// Curve on which a point lies according to one observation to known points.
struct Locus {
  enum Kind { kRay, kCircle, kAngle } kind = kCircle;
  Eigen::Vector2d a = Eigen::Vector2d::Zero();  ///< start of the ray; centre; first known point
  Eigen::Vector2d b = Eigen::Vector2d::Zero();  ///< second known point of an angle
  double value = 0.0;                           ///< azimuth [rad]; radius [m]; angle from a to b [rad]
};

/// Intersection of all loci: among the intersections of pairs the one with the smallest misfit. nullopt with
/// fewer than two loci, and where another intersection fits nearly as well (mirror images).
[[nodiscard]] std::optional<Eigen::Vector2d> intersection(std::vector<Locus> loci);

}  // namespace octant::calib
