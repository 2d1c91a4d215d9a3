// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/measurement.h"

#include <algorithm>
#include <cmath>

#include "models/physics/range.h"

namespace octant {
namespace {

/// Lower bound on distances, which keeps directions finite when a receiver coincides with the beacon.
constexpr double kMinDistanceM = 1e-6;

struct Leg {
  Eigen::Vector3d p_receiver_map_m;
  Eigen::Vector3d direction;  ///< unit vector from beacon to receiver
  double distance_m;
};

Leg leg_of(const Pose& T_map_vehicle, const Eigen::Vector3d& p_receiver_vehicle_m,
           const Eigen::Vector3d& p_beacon_map_m) {
  Leg leg;
  leg.p_receiver_map_m = T_map_vehicle * p_receiver_vehicle_m;
  const Eigen::Vector3d v = leg.p_receiver_map_m - p_beacon_map_m;
  leg.distance_m = std::max(v.norm(), kMinDistanceM);
  leg.direction = v / leg.distance_m;
  return leg;
}

/// Converts a derivative by a point of the vehicle, in the map, into one by the pose's tangent vector.
/// @param by_turn  additional effect of a rotation (in the vehicle's frame), beyond the motion of the point
Eigen::Matrix<double, 1, 6> by_pose(const Eigen::Vector3d& by_point_map, const Pose& T,
                                    const Eigen::Vector3d& o_vehicle_m, Motion motion,
                                    const Eigen::RowVector3d& by_turn = Eigen::RowVector3d::Zero()) {
  Eigen::Matrix<double, 1, 6> row = Eigen::Matrix<double, 1, 6>::Zero();
  const Eigen::RowVector3d by_point_vehicle = (T.rotation.conjugate() * by_point_map).transpose();
  const Eigen::RowVector3d by_rotation =
      by_turn - by_point_vehicle * skew(o_vehicle_m);  // d(R o) = R [delta]x o = -R [o]x delta
  if (motion == Motion::kPlanar) {
    row[0] = by_point_map.x();
    row[1] = by_point_map.y();
    row[2] = by_rotation[2];
  } else {
    row.head<3>() = by_point_map.transpose();
    row.tail<3>() = by_rotation;
  }
  return row;
}

/// Off-axis loss at a receiver: ln D and its derivative by the receiver's position in the map.
struct OffAxis {
  LogDirectivity log_gain;
  Eigen::Vector3d axis_map = Eigen::Vector3d::Zero();
  Eigen::RowVector3d by_receiver_map = Eigen::RowVector3d::Zero();
};

OffAxis off_axis(const PathInput& in, const Leg& leg) {
  OffAxis out;
  if (in.axis_vehicle == nullptr || !in.attenuation->directional() || in.axis_vehicle->isZero()) return out;
  out.axis_map = in.T_map_vehicle->rotation * *in.axis_vehicle;
  const double cosine = -out.axis_map.dot(leg.direction);
  out.log_gain = log_directivity(cosine, in.attenuation->half_power_angle_rad);
  // cos = -a . u with u = (o - p) / d, so d cos / d o = -(a + cos u)' / d.
  out.by_receiver_map =
      -out.log_gain.by_cosine / leg.distance_m * (out.axis_map + cosine * leg.direction).transpose();
  return out;
}

/// The axis turns with the vehicle: cos = -(R a) . u, d(R a) = -R [a]x delta.
Eigen::Matrix<double, 1, 6> off_axis_by_pose(const OffAxis& off, const Leg& leg, const PathInput& in,
                                             Motion motion) {
  if (off.axis_map.isZero()) return Eigen::Matrix<double, 1, 6>::Zero();
  const Eigen::Vector3d direction_vehicle = in.T_map_vehicle->rotation.conjugate() * leg.direction;
  const Eigen::RowVector3d by_turn =
      off.log_gain.by_cosine * direction_vehicle.transpose() * skew(*in.axis_vehicle);
  return by_pose(off.by_receiver_map.transpose(), *in.T_map_vehicle, in.p_receiver_vehicle_m, motion,
                 by_turn);
}

/// Walk and log amplitude at a distance, for a given gain.
struct Walk {
  double walk_s = 0.0, log_amplitude = 0.0;
  double by_log_amplitude = 0.0;  ///< derivative of the walk [s]
  double by_distance = 0.0;       ///< derivative of the log amplitude [1/m]
  double by_rise_time = 0.0;      ///< derivative of the walk
  bool heard = true;
};

Walk walk_at(double distance_m, double log_gain, const AttenuationModel& a,
             const std::optional<double>& measured) {
  Walk out;
  out.log_amplitude =
      std::log(a.amplitude_1m_v) - std::log(distance_m) - a.absorption_np_per_m * distance_m + log_gain;
  out.by_distance = -(1.0 / distance_m + a.absorption_np_per_m);
  double share = a.threshold_v * std::exp(-out.log_amplitude);
  out.heard = share < 1.0;
  share = measured ? std::min(a.threshold_v * std::exp(-*measured), kMostMeasuredShare)
                   : std::min(share, kMostPredictedShare);
  out.by_log_amplitude = measured ? 0.0 : -a.rise_time_s * share / (1.0 - share);
  out.by_rise_time = -std::log1p(-share);
  out.walk_s = a.rise_time_s * out.by_rise_time;
  return out;
}

}  // namespace

PathOutput predict_arrival_value(const PathInput& in) {
  PathOutput out;
  const Leg back = leg_of(*in.T_map_vehicle, in.p_receiver_vehicle_m, in.p_beacon_map_m);
  out.distance_m = back.distance_m;
  double legs = 1.0;
  if (in.T_hear_send != nullptr) {
    const Leg there = leg_of(*in.T_map_vehicle, *in.T_hear_send * in.p_receiver_vehicle_m, in.p_beacon_map_m);
    out.distance_m = 0.5 * (out.distance_m + there.distance_m);
    legs = 2.0;
  }
  out.tof_s = legs * out.distance_m / in.speed_mps + in.delay_s;
  if (in.attenuation != nullptr) {
    const Walk walk = walk_at(out.distance_m, off_axis(in, back).log_gain.value + in.log_gain,
                              *in.attenuation, in.log_amplitude);
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
  Eigen::Matrix<double, 1, 6> d_pose =
      by_pose(back.direction, *in.T_map_vehicle, in.p_receiver_vehicle_m, motion);
  double legs = 1.0;
  if (in.T_hear_send != nullptr) {
    const Eigen::Vector3d o_send = *in.T_hear_send * in.p_receiver_vehicle_m;
    const Leg there = leg_of(*in.T_map_vehicle, o_send, in.p_beacon_map_m);
    out.distance_m = 0.5 * (back.distance_m + there.distance_m);
    d_beacon = 0.5 * (d_beacon - there.direction.transpose());
    d_receiver = 0.5 * (d_receiver +
                        there.direction.transpose() * rotation * in.T_hear_send->rotation.toRotationMatrix());
    d_pose = 0.5 * (d_pose + by_pose(there.direction, *in.T_map_vehicle, o_send, motion));
    legs = 2.0;
  }
  const double slowness = legs / in.speed_mps;
  out.tof_s = legs * out.distance_m / in.speed_mps + in.delay_s;
  out.tof_by_speed = -legs * out.distance_m / (in.speed_mps * in.speed_mps);
  out.tof_by_beacon = slowness * d_beacon;
  out.tof_by_receiver = slowness * d_receiver;
  out.tof_by_pose = slowness * d_pose;
  out.tof_by_attenuation.setZero();
  if (in.attenuation == nullptr) return out;
  const OffAxis off = off_axis(in, back);
  const Walk walk =
      walk_at(out.distance_m, off.log_gain.value + in.log_gain, *in.attenuation, in.log_amplitude);
  out.tof_s += walk.walk_s;
  out.log_amplitude = walk.log_amplitude;
  out.heard = walk.heard;
  out.log_amplitude_by_beacon = walk.by_distance * d_beacon - off.by_receiver_map;
  out.log_amplitude_by_receiver = walk.by_distance * d_receiver + off.by_receiver_map * rotation;
  out.log_amplitude_by_pose = walk.by_distance * d_pose + off_axis_by_pose(off, back, in, motion);
  out.log_amplitude_by_attenuation << 1.0 / in.attenuation->amplitude_1m_v, -out.distance_m, 0.0,
      off.log_gain.by_half_power_angle;
  out.tof_by_beacon += walk.by_log_amplitude * out.log_amplitude_by_beacon;
  out.tof_by_receiver += walk.by_log_amplitude * out.log_amplitude_by_receiver;
  out.tof_by_pose += walk.by_log_amplitude * out.log_amplitude_by_pose;
  out.tof_by_attenuation = walk.by_log_amplitude * out.log_amplitude_by_attenuation;
  out.tof_by_attenuation[2] = walk.by_rise_time;
  return out;
}

BearingOutput predict_bearing(const Pose& T, const Eigen::Vector3d& p_reflector_map_m,
                              const Eigen::Vector3d& p_sensor_vehicle_m) {
  BearingOutput out;
  const Eigen::Matrix3d R = T.rotation.toRotationMatrix();
  const Eigen::Vector3d v =
      R.transpose() * (p_reflector_map_m - T.translation_m);  // reflector in the vehicle frame
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
