// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/localizers/common/pair_ranges.h"
#include "models/physics/pose.h"

namespace octant {

/// Covariance of a planar pose (x, y, heading) that a method computes from ranges. To first order
///   d pose = sum_i gain_i d range_i
/// and whatever else is not exactly known acts like an error of the ranges: a beacon that stands elsewhere by
/// e like -u'e (u: from beacon to receiver), a receiver by e like u'e, a delay by -gain_mps, the speed by
/// by_speed_s. What arrivals share does not average out, so it is summed before it is squared.
/// Cross-correlations of calibrated parameters are not used.
class RangePropagation {
 public:
  explicit RangePropagation(const Deployment& deployment);

  void clear();
  /// @param gain  d pose / d range, (m/m, m/m, rad/m)  @param T_map_vehicle  the pose found
  void add(const Eigen::Vector3d& gain, const PairRange& pair, const Pose& T_map_vehicle,
           const Deployment& deployment);
  [[nodiscard]] Eigen::Matrix3d covariance(const Deployment& deployment) const;

 private:
  struct Shared {
    Eigen::Matrix3d by_position = Eigen::Matrix3d::Zero();
    Eigen::Vector3d by_delay = Eigen::Vector3d::Zero();
    bool touched = false;
  };
  Eigen::Matrix3d noise_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d by_speed_ = Eigen::Vector3d::Zero();
  std::vector<Shared> beacons_, receivers_;
};

/// Variance of what calibration left uncertain of a pair, as far as it looks like an error of its range: for
/// gates [m^2].
[[nodiscard]] double calibration_variance_m2(const PairRange& pair, const Deployment& deployment);

/// A beacon and a receiver of a vehicle at a pose.
struct Sight {
  /// Unit vector from the beacon to the receiver, in the map; +z where they coincide.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double distance_m = 0.0;
  Eigen::Vector3d by_pose = Eigen::Vector3d::Zero();  ///< the distance by x, y, heading
};
[[nodiscard]] Sight sight_of(const Pose& T_map_vehicle, BeaconId beacon, ReceiverId receiver,
                             const Deployment& deployment);

}  // namespace octant
