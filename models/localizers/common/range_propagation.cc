// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/range_propagation.h"

#include <algorithm>

#include "models/physics/plane.h"

namespace octant {

Sight sight_of(const Pose& T_map_vehicle, BeaconId beacon, ReceiverId receiver,
               const Deployment& deployment) {
  const Eigen::Vector3d lever = T_map_vehicle.rotation * deployment.receivers[receiver.index()].position_m;
  const Eigen::Vector3d v =
      T_map_vehicle.translation_m + lever - deployment.beacons[beacon.index()].position_m;
  Sight sight{.distance_m = v.norm()};
  if (sight.distance_m > 0) sight.direction = v / sight.distance_m;
  const Eigen::Vector2d u = sight.direction.head<2>();
  sight.by_pose << u, u.dot(left_of(lever.head<2>()));
  return sight;
}

double calibration_variance_m2(const PairRange& pair, const Deployment& deployment) {
  const DeploymentBeacon& beacon = deployment.beacons[pair.beacon.index()];
  const DeploymentReceiver& receiver = deployment.receivers[pair.receiver.index()];
  // Mean over all directions, because the direction is not known yet.
  return 0.5 * beacon.covariance_m2.topLeftCorner<2, 2>().trace() +
         0.5 * receiver.sigma_m.head<2>().squaredNorm() + square(pair.gain_mps * beacon.delay_sigma_s) +
         square(pair.gain_mps * receiver.delay_sigma_s) +
         square(pair.by_speed_s * deployment.speed_sigma_mps);
}

template <int N>
PropagationOf<N>::PropagationOf(const Deployment& deployment)
    : beacons_(deployment.beacons.size()), receivers_(deployment.receivers.size()) {}

template <int N>
void PropagationOf<N>::clear() {
  noise_.setZero();
  by_speed_.setZero();
  std::ranges::fill(beacons_, Shared{});
  std::ranges::fill(receivers_, Shared{});
}

template <int N>
void PropagationOf<N>::add(const Gain& gain, const PairRange& pair, const Eigen::Vector3d& direction,
                           const Eigen::Matrix3d& R_map_vehicle) {
  const Eigen::RowVector3d u = direction.transpose();
  noise_ += pair.sigma_m * pair.sigma_m * gain * gain.transpose();
  by_speed_ += pair.by_speed_s * gain;
  Shared& beacon = beacons_[pair.beacon.index()];
  beacon.touched = true;
  beacon.by_position += gain * u;
  beacon.by_delay += pair.gain_mps * gain;
  Shared& receiver = receivers_[pair.receiver.index()];
  receiver.touched = true;
  receiver.by_position += gain * (u * R_map_vehicle);
  receiver.by_delay += pair.gain_mps * gain;
}

template <int N>
void PropagationOf<N>::add(const Gain& gain, const PairRange& pair, const Pose& T_map_vehicle,
                           const Deployment& deployment) {
  add(gain, pair, sight_of(T_map_vehicle, pair.beacon, pair.receiver, deployment).direction,
      T_map_vehicle.rotation.toRotationMatrix());
}

template <int N>
typename PropagationOf<N>::Covariance PropagationOf<N>::covariance(const Deployment& deployment) const {
  Covariance sum = noise_ + square(deployment.speed_sigma_mps) * by_speed_ * by_speed_.transpose();
  for (std::size_t i = 0; i < beacons_.size(); ++i) {
    if (!beacons_[i].touched) continue;
    const DeploymentBeacon& beacon = deployment.beacons[i];
    sum += beacons_[i].by_position * beacon.covariance_m2 * beacons_[i].by_position.transpose();
    sum += square(beacon.delay_sigma_s) * beacons_[i].by_delay * beacons_[i].by_delay.transpose();
  }
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    if (!receivers_[i].touched) continue;
    const DeploymentReceiver& receiver = deployment.receivers[i];
    sum += receivers_[i].by_position * receiver.sigma_m.cwiseAbs2().asDiagonal() *
           receivers_[i].by_position.transpose();
    sum += square(receiver.delay_sigma_s) * receivers_[i].by_delay * receivers_[i].by_delay.transpose();
  }
  return 0.5 * (sum + sum.transpose());
}

template class PropagationOf<3>;
template class PropagationOf<4>;

}  // namespace octant
