// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/localizers/common/pair_ranges.h"
#include "models/physics/pose.h"

namespace octant {

/// Covariance of N quantities that a method computes from ranges, such as a planar pose (x, y, heading) or
/// the ranges themselves. To first order
///   d quantity = sum_i gain_i d range_i
/// Uncertain parameters act like errors of the ranges: a beacon displaced by e like -u'e (u: from beacon to
/// receiver), a receiver by e like u'e, a delay by -gain_mps, the speed by by_speed_s. Errors that arrivals
/// share do not average out, so they are summed before squaring. Cross-correlations of calibrated parameters
/// are neglected.
template <int N>
class PropagationOf {
 public:
  using Gain = Eigen::Matrix<double, N, 1>;
  using Covariance = Eigen::Matrix<double, N, N>;
  explicit PropagationOf(const Deployment& deployment);

  void clear();
  /// @param gain  d quantity / d range  @param direction  unit vector from the beacon to the receiver, in the
  /// map  @param R_map_vehicle  rotation of the vehicle
  void add(const Gain& gain, const PairRange& pair, const Eigen::Vector3d& direction,
           const Eigen::Matrix3d& R_map_vehicle);
  /// @param T_map_vehicle  pose of the vehicle
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
/// Propagation to a pose: gains in m/m, m/m, rad/m.
using RangePropagation = PropagationOf<3>;

/// Variance of a pair's range due to the calibration, for gates [m^2].
[[nodiscard]] double calibration_variance_m2(const PairRange& pair, const Deployment& deployment);

/// Line of sight between a beacon and a receiver of a vehicle at a pose.
struct Sight {
  /// Unit vector from the beacon to the receiver, in the map; +z if they coincide.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double distance_m = 0.0;
  Eigen::Vector3d by_pose = Eigen::Vector3d::Zero();  ///< derivative of the distance by x, y, heading
};
[[nodiscard]] Sight sight_of(const Pose& T_map_vehicle, BeaconId beacon, ReceiverId receiver,
                             const Deployment& deployment);

}  // namespace octant
