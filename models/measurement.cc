// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/measurement.h"

#include <algorithm>
#include <cmath>

namespace octant {
namespace {

/// Beyond this share of threshold in amplitude the logarithm of the walk is held: a state under test may lie where
/// nothing would be heard, and the cost must stay finite there.
constexpr double kMaxThresholdShare = 0.995;
/// Keeps directions finite when a receiver sits on the beacon.
constexpr double kMinDistanceM = 1e-6;

struct Leg {
  Eigen::Vector3d p_receiver_map_m;
  Eigen::Vector3d direction;  ///< unit vector from beacon to receiver
  double distance_m;
};

Leg leg_of(const Pose& T_map_vehicle, const Eigen::Vector3d& p_receiver_vehicle_m, const Eigen::Vector3d& p_beacon_map_m) {
  Leg leg;
  leg.p_receiver_map_m = T_map_vehicle * p_receiver_vehicle_m;
  const Eigen::Vector3d v = leg.p_receiver_map_m - p_beacon_map_m;
  leg.distance_m = std::max(v.norm(), kMinDistanceM);
  leg.direction = v / leg.distance_m;
  return leg;
}

/// Derivative of the leg's distance by the pose's tangent vector.
Eigen::Matrix<double, 1, 6> by_pose(const Leg& leg, const Pose& T, const Eigen::Vector3d& o_vehicle_m, Motion motion) {
  Eigen::Matrix<double, 1, 6> row = Eigen::Matrix<double, 1, 6>::Zero();
  const Eigen::RowVector3d u_vehicle = (T.rotation.conjugate() * leg.direction).transpose();
  const Eigen::RowVector3d by_rotation = -u_vehicle * skew(o_vehicle_m);  // d(R o) = R [delta]x o = -R [o]x delta
  if (motion == Motion::kPlanar) {
    row[0] = leg.direction.x();
    row[1] = leg.direction.y();
    row[2] = by_rotation[2];
  } else {
    row.head<3>() = leg.direction.transpose();
    row.tail<3>() = by_rotation;
  }
  return row;
}

/// Walk and log amplitude at a distance, and their derivatives; `slope` is d ln A / d distance with changed sign.
struct Walk {
  double walk_s = 0.0, log_amplitude = 0.0, by_distance = 0.0, slope = 0.0;
  Eigen::RowVector3d by_attenuation = Eigen::RowVector3d::Zero();
  bool heard = true;
};

Walk walk_at(double distance_m, const AttenuationModel& a) {
  Walk out;
  out.log_amplitude = std::log(a.amplitude_1m_v) - std::log(distance_m) - a.absorption_np_per_m * distance_m;
  out.slope = 1.0 / distance_m + a.absorption_np_per_m;
  double share = a.threshold_v * std::exp(-out.log_amplitude);
  out.heard = share < 1.0;
  share = std::min(share, kMaxThresholdShare);
  const double steepness_s = a.rise_time_s * share / (1.0 - share);  // d walk / d ln(1/A)
  out.walk_s = -a.rise_time_s * std::log1p(-share);
  out.by_distance = steepness_s * out.slope;
  out.by_attenuation << -steepness_s / a.amplitude_1m_v, steepness_s * distance_m, -std::log1p(-share);
  return out;
}

}  // namespace

PathOutput predict_arrival_value(const PathInput& in) {
  PathOutput out;
  out.distance_m = leg_of(*in.T_map_vehicle, in.p_receiver_vehicle_m, in.p_beacon_map_m).distance_m;
  double legs = 1.0;
  if (in.T_hear_send != nullptr) {
    const Leg there = leg_of(*in.T_map_vehicle, *in.T_hear_send * in.p_receiver_vehicle_m, in.p_beacon_map_m);
    out.distance_m = 0.5 * (out.distance_m + there.distance_m);
    legs = 2.0;
  }
  out.tof_s = legs * out.distance_m / in.speed_mps + in.delay_s;
  if (in.attenuation != nullptr) {
    const Walk walk = walk_at(out.distance_m, *in.attenuation);
    out.tof_s += walk.walk_s;
    out.log_amplitude = walk.log_amplitude;
    out.heard = walk.heard;
  }
  return out;
}

PathOutput predict_arrival(const PathInput& in, Motion motion) {
  PathOutput out;
  const Leg back = leg_of(*in.T_map_vehicle, in.p_receiver_vehicle_m, in.p_beacon_map_m);
  const auto rotation = in.T_map_vehicle->rotation.toRotationMatrix();
  out.distance_m = back.distance_m;
  Eigen::RowVector3d d_beacon = -back.direction.transpose();
  Eigen::RowVector3d d_receiver = back.direction.transpose() * rotation;
  Eigen::Matrix<double, 1, 6> d_pose = by_pose(back, *in.T_map_vehicle, in.p_receiver_vehicle_m, motion);
  double legs = 1.0;
  if (in.T_hear_send != nullptr) {
    const Eigen::Vector3d o_send = *in.T_hear_send * in.p_receiver_vehicle_m;
    const Leg there = leg_of(*in.T_map_vehicle, o_send, in.p_beacon_map_m);
    out.distance_m = 0.5 * (back.distance_m + there.distance_m);
    d_beacon = 0.5 * (d_beacon - there.direction.transpose());
    d_receiver = 0.5 * (d_receiver + there.direction.transpose() * rotation * in.T_hear_send->rotation.toRotationMatrix());
    d_pose = 0.5 * (d_pose + by_pose(there, *in.T_map_vehicle, o_send, motion));
    legs = 2.0;
  }
  double gain = legs / in.speed_mps;
  out.tof_s = legs * out.distance_m / in.speed_mps + in.delay_s;
  out.tof_by_speed = -legs * out.distance_m / (in.speed_mps * in.speed_mps);
  out.tof_by_attenuation.setZero();
  if (in.attenuation != nullptr) {
    const Walk walk = walk_at(out.distance_m, *in.attenuation);
    out.tof_s += walk.walk_s;
    out.log_amplitude = walk.log_amplitude;
    out.heard = walk.heard;
    gain += walk.by_distance;
    out.tof_by_attenuation = walk.by_attenuation;
    out.log_amplitude_by_beacon = -walk.slope * d_beacon;
    out.log_amplitude_by_receiver = -walk.slope * d_receiver;
    out.log_amplitude_by_pose = -walk.slope * d_pose;
    out.log_amplitude_by_attenuation << 1.0 / in.attenuation->amplitude_1m_v, -out.distance_m, 0.0;
  }
  out.tof_by_beacon = gain * d_beacon;
  out.tof_by_receiver = gain * d_receiver;
  out.tof_by_pose = gain * d_pose;
  return out;
}

BearingOutput predict_bearing(const Pose& T, const Eigen::Vector3d& p_reflector_map_m, const Eigen::Vector3d& p_sensor_vehicle_m) {
  BearingOutput out;
  const Eigen::Matrix3d R = T.rotation.toRotationMatrix();
  const Eigen::Vector3d v = R.transpose() * (p_reflector_map_m - T.translation_m);  // reflector in the vehicle frame
  const double x = v.x() - p_sensor_vehicle_m.x(), y = v.y() - p_sensor_vehicle_m.y();
  const double n2 = std::max(x * x + y * y, kMinDistanceM * kMinDistanceM);
  out.bearing_rad = std::atan2(y, x);
  const Eigen::RowVector3d by_v(-y / n2, x / n2, 0.0);
  out.by_reflector = by_v * R.transpose();
  // v turns against the heading: dv/dheading = -ez x v.
  out.by_pose << -out.by_reflector[0], -out.by_reflector[1], by_v[0] * v.y() - by_v[1] * v.x();
  return out;
}

}  // namespace octant
