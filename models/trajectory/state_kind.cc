// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/state_kind.h"

#include <algorithm>
#include <cmath>

namespace octant {
namespace {

constexpr double kStandsStill = 0.1;

}  // namespace

StateKind state_kind(const MeasurementLog& log, VehicleId vehicle, const TrajectoryModel& model) {
  const auto rows = std::ranges::count(log.odometry, vehicle, &OdometryStep::vehicle);
  const bool has_odometry = rows >= 2;
  if (log.has_epochs) return has_odometry ? StateKind::kChainedStops : StateKind::kStops;
  if (has_odometry) return StateKind::kDrive;
  const bool has_prior =
      vehicle.index() < model.motion_priors.size() && model.motion_priors[vehicle.index()].has_value();
  if (has_prior && log.poses.empty() && model.motion == Motion::kPlanar &&
      model.timing.clock != Clock::kCycleOffset)
    return StateKind::kMotion;
  return StateKind::kMoments;
}

double longest_tie_s(StateKind kind) {
  switch (kind) {
    case StateKind::kStops: return 0.0;
    case StateKind::kMotion: return kSilence_s;
    case StateKind::kMoments: return kMoment_s;
    case StateKind::kChainedStops:
    case StateKind::kDrive: break;
  }
  return INFINITY;
}

std::size_t end_of_moment(const MeasurementLog& log, const std::vector<std::size_t>& arrivals,
                          std::size_t first, const Pose* T, double noise_m) {
  const PoseAccuracy& accuracy = log.pose_accuracy;
  const double time_s = log.arrivals[arrivals[first]].time_s,
               still_m = kStandsStill * std::min(accuracy.position_sigma_m, noise_m),
               still_rad = kStandsStill * accuracy.attitude_sigma_rad;
  const auto belongs = [&](double other_s) {
    if (other_s == time_s) return true;
    Pose other;
    return T != nullptr && other_s - time_s <= kMoment_s &&
           interpolate_poses(log.poses, other_s, accuracy.max_gap_s, other) &&
           (other.translation_m - T->translation_m).norm() <= still_m &&
           other.rotation.angularDistance(T->rotation) <= still_rad;
  };
  std::size_t last = first + 1;
  while (last < arrivals.size() && belongs(log.arrivals[arrivals[last]].time_s)) ++last;
  return last;
}

}  // namespace octant
