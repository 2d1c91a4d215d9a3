// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace octant::calib {

/// A range from a known place.
struct RangeFrom {
  Eigen::Vector3d p_map_m;
  double range_m = 0.0;
};

/// A horizontal direction observed from a known position by a vehicle of known heading.
struct RayFrom {
  Eigen::Vector2d p_map_m;
  double direction_rad = 0.0;  ///< in the map, counter-clockwise from +x
  double sigma_rad = 0.01;
};

struct TrilaterationOptions {
  std::array<bool, 3> held = {false, false, false};  ///< coordinates that keep the value of `guess`
  Eigen::Vector3d guess = Eigen::Vector3d::Zero();
  double scale_m = 0.05;  ///< spread of good ranges
  bool above = true;      ///< with places in one horizontal plane: take the solution above them
};

struct Trilateration {
  bool ok = false;
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
  int agreeing = 0;   ///< ranges and rays within three scales
  double cost = 0.0;  ///< robust, in squared scales
};

/// Position of a beacon from ranges to known positions, robust against outliers. Linear solutions of random
/// subsets
///   2 q'p - |p|^2 = |q|^2 - r^2   (difference of squares, Figueroa and Mahajan 1994 without the speed)
/// and crossings of rays give candidates. The candidate with which most ranges and rays agree is refined
/// under Cauchy's loss. Positions are known to scale_m, and so is the direction of a ray over its length.
/// Deterministic.
[[nodiscard]] Trilateration trilaterate(const std::vector<RangeFrom>& ranges,
                                        const TrilaterationOptions& options,
                                        const std::vector<RayFrom>& rays = {});

/// In planar motion, a position below the receivers and its image above them explain the arrivals equally
/// well. Returns the one of both heights on the side of the receivers where the beacon is known to be.
/// @param receivers  all of the vehicles, with their positions; at least one
template <class Receivers>
[[nodiscard]] double height_on_known_side_m(const Receivers& receivers, double known_m, double found_m) {
  double receivers_m = 0.0;
  for (const auto& r : receivers) receivers_m += r.position_m.z() / static_cast<double>(receivers.size());
  return (known_m - receivers_m) * (found_m - receivers_m) < 0 ? 2 * receivers_m - found_m : found_m;
}

/// Mirror image of a position that explains the ranges nearly as well: in the plane, or in the vertical plane
/// of the positions of the ranges. No value if the ranges distinguish the two, or both are within two scales.
[[nodiscard]] std::optional<Eigen::Vector3d> mirror_image_of(const Eigen::Vector3d& p_map_m,
                                                             const std::vector<RangeFrom>& ranges,
                                                             const TrilaterationOptions& options);

}  // namespace octant::calib
