// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace octant::calib {

/// A range from a known place.
struct RangeFrom {
  Eigen::Vector3d p_map_m;
  double range_m = 0.0;
};

struct TrilaterationOptions {
  std::array<bool, 3> held = {false, false, false};  ///< coordinates that keep the value of `guess`
  Eigen::Vector3d guess = Eigen::Vector3d::Zero();
  double scale_m = 0.05;        ///< spread of good ranges
  bool above = true;            ///< with places in one horizontal plane: take the solution above them
};

struct Trilateration {
  bool ok = false;
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
  int agreeing = 0;              ///< ranges within three scales
  double cost = 0.0;             ///< robust, in squared scales
  double weakest_sigma_m = 0.0;  ///< largest standard deviation of the position, from scale_m
  /// A second place, off by more than its uncertainty, that explains the ranges nearly as well.
  bool has_mirror = false;
  Eigen::Vector3d mirror_map_m = Eigen::Vector3d::Zero();
};

/// Place of a beacon from ranges to known places, none of the ranges trusted: linear solutions of random subsets
///   2 q'p - |p|^2 = |q|^2 - r^2   (difference of squares, Figueroa and Mahajan 1994 without the speed)
/// give candidates, the one that most ranges agree with is refined under Cauchy's loss. Deterministic.
[[nodiscard]] Trilateration trilaterate(const std::vector<RangeFrom>& ranges, const TrilaterationOptions& options);

}  // namespace octant::calib
