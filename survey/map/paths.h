// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: single paths, for computations outside the SIMD kernels.

#include <vector>

#include <Eigen/Core>

#include "survey/geometry/map_kernel.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

using UnknownsVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 7, 1>;
using UnknownsMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 7>;

struct HeardPath {
  std::size_t beacon = 0, receiver = 0;
  Eigen::Vector3d unit = Eigen::Vector3d::Zero();  ///< from the beacon to the receiver
  double distance_m = 0.0, weight = 0.0;           ///< 1 / variance of the range
  double heading_rad = 0.0;                        ///< heading of the vehicle
  UnknownsVector row;                              ///< derivative of the range by the unknowns
};

struct PoseAt {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0, heading_rad = 0.0;
};

/// Range from a beacon to a receiver and its derivatives, received or not.
[[nodiscard]] HeardPath path_between(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                                     const PoseAt& pose);

/// The received paths at pose i of a tile, beacon by beacon.
void heard_paths(const SurveyModel& model, const KernelTile& tile, const PoseAt& pose,
                 std::vector<HeardPath>& paths);

}  // namespace octant::survey
