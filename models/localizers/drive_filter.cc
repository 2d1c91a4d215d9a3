// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive_filter.h"

#include <algorithm>
#include <cmath>

#include "models/measurement.h"

namespace octant {
namespace {

constexpr double kForget = 1.0 / 30.0;
constexpr int kIterations = 3;

/// What calibration may be off by. It widens the gate only: it does not average out, so it must not count as noise.
double calibration_variance_s2(const EpochFixModel& model, BeaconId beacon, const PathOutput& path) {
  if (beacon.index() >= model.beacon_covariance.size()) return 0.0;
  Eigen::Matrix<double, 5, 1> by;
  by << path.tof_by_beacon.transpose(), 1.0, path.tof_by_speed;
  return std::max(0.0, by.dot(model.beacon_covariance[beacon.index()] * by));
}

}  // namespace

void DriveFilter::start(const Pose& T_map_vehicle, const Eigen::Matrix3d& covariance) {
  T_map_vehicle_ = T_map_vehicle;
  covariance_ = covariance;
  acceptance_ = 1.0;
}

void DriveFilter::predict(const Pose& step, const OdometryObservation& whole, double share) {
  const double heading = T_map_vehicle_.heading_rad(), c = std::cos(heading), s = std::sin(heading);
  const double dx = step.translation_m.x(), dy = step.translation_m.y();
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = -s * dx - c * dy;
  F(1, 2) = c * dx - s * dy;
  covariance_ = F * covariance_ * F.transpose();
  const double distance2 = share * whole.distance_sigma_m * whole.distance_sigma_m;  // the same in all directions
  covariance_.diagonal() += Eigen::Vector3d(distance2, distance2, share * whole.heading_sigma_rad * whole.heading_sigma_rad);
  T_map_vehicle_ = T_map_vehicle_ * step;
}

Rejection DriveFilter::update(const Trajectory& trajectory, const ArrivalObservation& a) {
  if (!model_.beacon_usable[a.beacon.index()]) return Rejection::kBeaconUnusable;
  PathInput in;
  in.p_beacon_map_m = model_.state.beacon_p_map_m[a.beacon.index()];
  in.p_receiver_vehicle_m = model_.state.receiver_p_vehicle_m[a.receiver.index()];
  in.speed_mps = a.model_speed_mps + model_.state.speed_offset(trajectory.run);
  in.delay_s = model_.state.delay_s(a.beacon, a.receiver) + (a.two_way ? trajectory.turnaround_s : 0.0);
  in.attenuation = model_.state.attenuation ? &*model_.state.attenuation : nullptr;
  in.axis_vehicle = model_.state.axis_of(a.receiver);
  in.log_amplitude = walk_amplitude(a, model_.state);
  in.T_hear_send = a.two_way ? &trajectory.T_hear_send[static_cast<std::size_t>(a.hear_send)] : nullptr;
  const double slack_s = range_slack_m_ * (a.two_way ? 2.0 : 1.0) / in.speed_mps;
  const double noise2 = a.sigma_s * a.sigma_s + slack_s * slack_s;

  // Iterated: the measurement is linearised where it puts the pose; the misfit of the prior comes along in `moved`.
  Pose T = T_map_vehicle_;
  Eigen::Vector3d moved = Eigen::Vector3d::Zero(), gain = Eigen::Vector3d::Zero();
  Eigen::RowVector3d H = Eigen::RowVector3d::Zero();
  for (int k = 0; k < kIterations; ++k) {
    in.T_map_vehicle = &T;
    const PathOutput out = predict_arrival(in, Motion::kPlanar);
    H = out.tof_by_pose.head<3>();
    const double S = H * covariance_ * H.transpose() + noise2;
    const double innovation = a.tof_s - out.tof_s + H.dot(moved);
    if (k == 0 && innovation * innovation > gate_sigmas_ * gate_sigmas_ * (S + calibration_variance_s2(model_, a.beacon, out))) {
      acceptance_ -= kForget * acceptance_;
      return innovation > 0 ? Rejection::kLate : Rejection::kEarly;
    }
    gain = covariance_ * H.transpose() / S;
    moved = gain * innovation;
    T = retract(T_map_vehicle_, moved, Motion::kPlanar);
  }
  // Joseph's form keeps the covariance positive.
  const Eigen::Matrix3d A = Eigen::Matrix3d::Identity() - gain * H;
  covariance_ = A * covariance_ * A.transpose() + noise2 * gain * gain.transpose();
  T_map_vehicle_ = T;
  acceptance_ += kForget * (1.0 - acceptance_);
  return Rejection::kUsed;
}

}  // namespace octant
