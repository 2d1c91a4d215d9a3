// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>

#include <Eigen/Core>

#include "models/physics/attenuation.h"
#include "models/physics/pose.h"

namespace octant {

/// Inputs of the prediction of one arrival. Pointers are not owned; optional ones are null.
struct PathInput {
  const Pose* T_map_vehicle = nullptr;  ///< pose at time_s
  Eigen::Vector3d p_beacon_map_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_receiver_vehicle_m = Eigen::Vector3d::Zero();
  double speed_mps = 343.0;
  double delay_s =
      0.0;  ///< delay of beacon and receiver, plus turnaround time and cycle offset where they apply
  const AttenuationModel* attenuation = nullptr;
  /// Two-way ranging: T_hear_send, the pose at the time of the request in the frame of the pose at the time
  /// of reception.
  const Pose* T_hear_send = nullptr;
  /// Unit vector of the receiver's axis in the vehicle frame. Null or zero: omnidirectional. Used only if the
  /// attenuation is directional.
  const Eigen::Vector3d* axis_vehicle = nullptr;
  double log_gain = 0.0;  ///< natural logarithm of the beacon's amplitude relative to the attenuation model,
                          ///< for a beacon that dirt or age dampens
  /// Measured ln(A / 1 V). If given, the walk follows from it instead of the predicted amplitude, and then
  /// carries no information about the states.
  std::optional<double> log_amplitude{};
};

/// Derivatives by the unknowns of an AttenuationModel.
using AttenuationRow = Eigen::Matrix<double, 1, kAttenuationUnknowns>;

/// Predicted time of flight and log amplitude of an arrival, with their derivatives. Derivatives by the pose
/// use the tangent of Motion: planar (x, y, heading), spatial (translation, body rotation).
struct PathOutput {
  bool heard = true;  ///< false below the threshold; the walk is then that of an amplitude just above it
  double distance_m = 0.0;  ///< one way; half the sum of both ways for two-way ranging
  double tof_s = 0.0;
  double log_amplitude =
      std::numeric_limits<double>::quiet_NaN();  ///< ln(A / 1 V), with an attenuation model

  Eigen::RowVector3d tof_by_beacon;         ///< s/m
  Eigen::RowVector3d tof_by_receiver;       ///< s/m, in the vehicle frame
  Eigen::Matrix<double, 1, 6> tof_by_pose;  ///< planar motion uses the first three columns
  double tof_by_speed = 0.0;                ///< s/(m/s)
  AttenuationRow tof_by_attenuation;

  Eigen::RowVector3d log_amplitude_by_beacon, log_amplitude_by_receiver;
  AttenuationRow log_amplitude_by_attenuation;
  Eigen::Matrix<double, 1, 6> log_amplitude_by_pose;
};

/// Evaluates the measurement equation:
///   tof = |T o - p| / c + delay + walk,   walk = -tau ln(1 - V_th / A),   A = A_1m / d exp(-alpha d)
///   D(theta)
/// With two-way ranging the path is (|T o - p| + |T T_hear_send o - p|) / c. The amplitude then uses the mean
/// distance of both ways, and theta that of the reply. Derivatives by a delay or a cycle offset are 1.
[[nodiscard]] PathOutput predict_arrival(const PathInput& input, Motion motion);
/// Evaluates the equation without derivatives: only heard, distance_m, tof_s and log_amplitude are set.
[[nodiscard]] PathOutput predict_arrival_value(const PathInput& input);

/// Bearing of a reflector from a pose, in the vehicle frame, in (-pi, pi]; derivatives by the reflector's
/// position (x, y, z) and by the planar pose.
struct BearingOutput {
  double bearing_rad = 0.0;
  Eigen::RowVector3d by_reflector;
  Eigen::RowVector3d by_pose;
};
[[nodiscard]] BearingOutput predict_bearing(const Pose& T_map_vehicle,
                                            const Eigen::Vector3d& p_reflector_map_m,
                                            const Eigen::Vector3d& p_sensor_vehicle_m);

}  // namespace octant
