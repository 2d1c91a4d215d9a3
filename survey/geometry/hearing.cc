// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/hearing.h"
#include "models/physics/plane.h"

#include <algorithm>
#include <cmath>

namespace octant::survey {
namespace {

bool stops(const WallPiece& wall, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector2d along = wall.to_m - wall.from_m, a = from.head<2>(), b = to.head<2>();
  const double sa = cross(along, a - wall.from_m), sb = cross(along, b - wall.from_m);
  if (!(sa * sb < 0)) return false;
  if (!(cross(b - a, wall.from_m - a) * cross(b - a, wall.to_m - a) < 0)) return false;
  const double z_m = from.z() + sa / (sa - sb) * (to.z() - from.z());
  return z_m > wall.bottom_m && z_m < wall.top_m;
}

double gain(const SurveyModel& model, std::size_t pattern, const Eigen::Vector3d& axis,
            const Eigen::Vector3d& towards) {
  return pattern == kAllRound || axis.isZero() ? 1.0 : beam_gain(model.patterns[pattern], axis.dot(towards));
}

}  // namespace

bool loud_enough(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                 const Eigen::Vector3d& unit, double distance_m, const Eigen::Vector3d& receiver_axis) {
  const Hearing& h = model.hearing;
  if (distance_m > h.range_m) return false;
  const SurveyBeacon& b = model.beacons[beacon];
  const double both = gain(model, b.pattern, b.axis, unit) *
                      gain(model, model.receivers[receiver].pattern, receiver_axis, -unit);
  return both > 0 &&
         (!(h.threshold_v > 0) || both * h.amplitude_1m_v * std::exp(-h.absorption_np_per_m * distance_m) >=
                                      h.threshold_v * distance_m);
}

bool hears(const SurveyModel& model, std::size_t beacon, std::size_t receiver, const Pose& T_map_vehicle) {
  const SurveyReceiver& r = model.receivers[receiver];
  const Eigen::Vector3d& from = model.beacons[beacon].p_map_m;
  const Eigen::Vector3d p = T_map_vehicle * r.p_vehicle_m;
  const double distance_m = (p - from).norm();
  return distance_m > 0 &&
         loud_enough(model, beacon, receiver, (p - from) / distance_m, distance_m,
                     T_map_vehicle.rotation * r.axis) &&
         std::ranges::none_of(model.walls, [&](const WallPiece& wall) { return stops(wall, from, p); });
}

}  // namespace octant::survey
