// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace octant::calib {

/// Measured distance between two points.
struct RangeEdge {
  int from = 0, to = 0;
  double length_m = 0.0;
};

/// Points placed by distances to neighbours alone, in a frame of their own. `column` is -1 for a point
/// outside the largest connected part.
struct PlacedByRanges {
  Eigen::MatrixXd positions_m;  ///< one column a point
  std::vector<int> column;
};

/// Classical multidimensional scaling of the shortest paths, refined by majorization of the stress (SMACOF,
/// de Leeuw 1977) with weights that decrease with the residual, so that echoes lose their influence.
/// @param dimensions  2 or 3
/// @param start  0: the classical scaling as it is; others: displaced at random by a part of its extent
[[nodiscard]] PlacedByRanges place_by_ranges(int points, const std::vector<RangeEdge>& edges, int dimensions,
                                             int start = 0);

/// Rigid motion, with or without a reflection, that fits `from` to `to` best (Kabsch); one column a point.
struct RigidFit {
  Eigen::MatrixXd rotation;
  Eigen::VectorXd shift_m;
  double rms_m = 0.0;
};
[[nodiscard]] RigidFit fit_rigidly(const Eigen::MatrixXd& from, const Eigen::MatrixXd& to, bool reflected);

}  // namespace octant::calib
