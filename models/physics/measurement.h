// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>

#include <Eigen/Core>

#include "models/physics/attenuation.h"
#include "models/physics/pose.h"

namespace octant {

/// What one arrival is predicted from. Pointers are not owned; null where there is none.
struct PathInput {
  const Pose* T_map_vehicle = nullptr;  ///< at time_s
  Eigen::Vector3d p_beacon_map_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_receiver_vehicle_m = Eigen::Vector3d::Zero();
  double speed_mps = 343.0;
  double delay_s = 0.0;  ///< beacon's plus receiver's, plus turnaround and cycle offset where they apply
  const AttenuationModel* attenuation = nullptr;
  /// Two-way ranging: T_hear_send, the vehicle's pose when it asked, in the frame of its pose when it heard
  /// the reply.
  const Pose* T_hear_send = nullptr;
  /// Unit vector in which the receiver hears best, in the vehicle frame; null or zero: all round alike.
  /// Counts where the attenuation is directional.
  const Eigen::Vector3d* axis_vehicle = nullptr;
  double log_gain =
      0.0;  ///< of the beacon over the attenuation's amplitude, ln: dirt and age dampen one alone
  /// ln(A / 1 V) as measured: then the walk is that of this amplitude instead of the predicted one, and tells
  /// nothing of the states.
  std::optional<double> log_amplitude{};
};

/// By the unknowns of an AttenuationModel.
using AttenuationRow = Eigen::Matrix<double, 1, kAttenuationUnknowns>;

/// Time of flight and log amplitude predicted for an arrival, with their derivatives.
/// Rows with respect to the pose use the tangent of Motion: planar (x, y, heading), spatial (translation,
/// body rotation).
struct PathOutput {
  bool heard = true;        ///< false: below threshold; the walk is then that of an amplitude just above it
  double distance_m = 0.0;  ///< one way; for two-way ranging half the sum
  double tof_s = 0.0;
  double log_amplitude =
      std::numeric_limits<double>::quiet_NaN();  ///< ln(A / 1 V), with an attenuation model

  Eigen::RowVector3d tof_by_beacon;         ///< s/m
  Eigen::RowVector3d tof_by_receiver;       ///< s/m, in the vehicle frame
  Eigen::Matrix<double, 1, 6> tof_by_pose;  ///< planar uses the first three
  double tof_by_speed = 0.0;                ///< s/(m/s)
  AttenuationRow tof_by_attenuation;

  Eigen::RowVector3d log_amplitude_by_beacon, log_amplitude_by_receiver;
  AttenuationRow log_amplitude_by_attenuation;
  Eigen::Matrix<double, 1, 6> log_amplitude_by_pose;
};

/// The measurement equation:
///   tof = |T o - p| / c + delay + walk,   walk = -tau ln(1 - V_th / A),   A = A_1m / d exp(-alpha d)
///   D(theta)
/// Two-way: (|T o - p| + |T T_hear_send o - p|) / c + ..., both legs' mean distance in A, and theta of the
/// way back. The derivative by a delay or a cycle offset is 1.
[[nodiscard]] PathOutput predict_arrival(const PathInput& input, Motion motion);
/// The same without derivatives (only heard, distance_m, tof_s, log_amplitude are set).
[[nodiscard]] PathOutput predict_arrival_value(const PathInput& input);

/// Bearing of a reflector from a pose, in the vehicle frame, (-pi, pi]; derivatives by reflector (x, y, z)
/// and pose (planar).
struct BearingOutput {
  double bearing_rad = 0.0;
  Eigen::RowVector3d by_reflector;
  Eigen::RowVector3d by_pose;
};
[[nodiscard]] BearingOutput predict_bearing(const Pose& T_map_vehicle,
                                            const Eigen::Vector3d& p_reflector_map_m,
                                            const Eigen::Vector3d& p_sensor_vehicle_m);

}  // namespace octant
