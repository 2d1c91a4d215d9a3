// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/localizers/common/pair_ranges.h"
#include "models/physics/pose.h"

namespace octant {

/// Covariance of N numbers that a method computes from ranges: of a planar pose (x, y, heading), or of the
/// ranges themselves. To first order
///   d number = sum_i gain_i d range_i
/// and whatever else is not exactly known acts like an error of the ranges: a beacon that stands elsewhere by
/// e like -u'e (u: from beacon to receiver), a receiver by e like u'e, a delay by -gain_mps, the speed by
/// by_speed_s. What arrivals share does not average out, so it is summed before it is squared.
/// Cross-correlations of calibrated parameters are not used.
template <int N>
class PropagationOf {
 public:
  using Gain = Eigen::Matrix<double, N, 1>;
  using Covariance = Eigen::Matrix<double, N, N>;
  explicit PropagationOf(const Deployment& deployment);

  void clear();
  /// @param gain  d number / d range  @param direction  unit vector from the beacon to the receiver, in the
  /// map  @param R_map_vehicle  that turns the receiver's place
  void add(const Gain& gain, const PairRange& pair, const Eigen::Vector3d& direction,
           const Eigen::Matrix3d& R_map_vehicle);
  /// @param T_map_vehicle  the pose found
  void add(const Gain& gain, const PairRange& pair, const Pose& T_map_vehicle, const Deployment& deployment);
  [[nodiscard]] Covariance covariance(const Deployment& deployment) const;

 private:
  struct Shared {
    Eigen::Matrix<double, N, 3> by_position = Eigen::Matrix<double, N, 3>::Zero();
    Gain by_delay = Gain::Zero();
    bool touched = false;
  };
  Covariance noise_ = Covariance::Zero();
  Gain by_speed_ = Gain::Zero();
  std::vector<Shared> beacons_, receivers_;
};
/// Of a pose: gains in m/m, m/m, rad/m.
using RangePropagation = PropagationOf<3>;

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
