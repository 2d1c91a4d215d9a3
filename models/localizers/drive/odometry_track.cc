// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/odometry_track.h"

#include <cmath>

#include "models/trajectory/odometry_noise.h"

namespace octant {

BodySpeed body_speed(double left_mps, double right_mps, double track_width_m) {
  return {(left_mps + right_mps) / 2, (right_mps - left_mps) / track_width_m};
}

Pose advance(const Pose& T_map_vehicle, const BodySpeed& body, double period_s) {
  const double heading = T_map_vehicle.heading_rad() + period_s * body.turn_rate_radps;  // eq. 1, third row
  const double step_m = period_s * body.speed_mps;
  return Pose::planar(T_map_vehicle.translation_m.x() + step_m * std::cos(heading),  // eq. 1, first row
                      T_map_vehicle.translation_m.y() + step_m * std::sin(heading),  // eq. 1, second row
                      heading);
}

void advance(OdometryState& state, const OdometryStep& step, const OdometryAccuracy& accuracy,
             double fraction) {
  const double dx = fraction * step.dx_m, dy = fraction * step.dy_m, turn = fraction * step.dheading_rad;
  const double c = std::cos(state.heading_rad), s = std::sin(state.heading_rad);
  const Eigen::Vector2d move(c * dx - s * dy, s * dx + c * dy);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = -move.y();
  F(1, 2) = move.x();
  const OdometryVariance variance = variance_of(step, accuracy);
  state.covariance = F * state.covariance * F.transpose();
  state.covariance.diagonal() +=
      fraction * Eigen::Vector3d(variance.distance_m2, variance.distance_m2, variance.heading_rad2);
  state.p_map_m += move;
  state.heading_rad = wrap_angle(state.heading_rad + turn);
}

std::vector<TimedPose> odometry_track(std::span<const OdometryStep> steps, const Pose& T_map_anchor) {
  std::vector<TimedPose> track;
  track.reserve(steps.size());
  Pose T = T_map_anchor;
  for (const OdometryStep& step : steps) {
    if (!track.empty()) T = T * Pose::planar(step.dx_m, step.dy_m, step.dheading_rad);
    track.push_back({step.time_s, T});
  }
  return track;
}

}  // namespace octant
