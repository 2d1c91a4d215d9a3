// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/pose.h"
#include "models/run.h"

namespace octant {

/// Speed and turn rate of a vehicle with two driven wheels, from their rim speeds and the distance between them.
struct BodySpeed {
  double speed_mps = 0.0;
  double turn_rate_radps = 0.0;
};
[[nodiscard]] BodySpeed body_speed(double left_mps, double right_mps, double track_width_m);

/// Pose one period later (Smieszek eq. 1). The step is straight, in the direction at its end: off an arc by half a turn of the
/// step, v omega dt^2 / 2, which is why the period should be short.
[[nodiscard]] Pose advance(const Pose& T_map_vehicle, const BodySpeed& body, double period_s);

/// A planar pose that odometry carries on, and its covariance (x, y in the map, heading).
struct OdometryState {
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  [[nodiscard]] Pose pose() const { return Pose::planar(p_map_m.x(), p_map_m.y(), heading_rad); }
};

/// Moves on by a fraction (0 to 1) of an odometry row; noise as `OdometryAccuracy` says, its variance in proportion.
void advance(OdometryState& state, const OdometryStep& step, const OdometryAccuracy& accuracy, double fraction = 1.0);

/// Poses at all rows from the anchor's pose on: odometry alone.
[[nodiscard]] std::vector<TimedPose> odometry_track(std::span<const OdometryStep> steps, const Pose& T_map_anchor);

}  // namespace octant
