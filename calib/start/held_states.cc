// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/held_states.h"

#include <cmath>
#include <utility>

namespace octant::calib {

namespace {

constexpr double kHeadingHeldToRad = 0.1;  ///< error of the search if beacons have errors of a few decimetres

bool stands_in_the_plane(const Trajectory& t) { return !t.moving && t.motion == Motion::kPlanar; }

}  // namespace

HeldStates::HeldStates(std::vector<Trajectory>* trajectories, bool (*is_held)(const Trajectory&),
                       const PoseObservation& like)
    : trajectories_(trajectories) {
  if (trajectories == nullptr) return;
  for (Trajectory& t : *trajectories) {
    poses_.push_back(t.poses);
    segments_.push_back(t.segments);
    if (is_held(t)) hold(t, like);
  }
}

HeldStates::~HeldStates() {
  if (trajectories_ == nullptr) return;
  for (std::size_t i = 0; i < trajectories_->size(); ++i) {
    (*trajectories_)[i].poses = std::move(poses_[i]);
    (*trajectories_)[i].segments = std::move(segments_[i]);
  }
}

void HeldStates::hold(Trajectory& t, const PoseObservation& like) {
  std::vector<PoseObservation> all;
  for (Segment& segment : t.segments) {
    const std::size_t first = all.size();
    all.insert(all.end(), t.poses.begin() + static_cast<std::ptrdiff_t>(segment.first_pose),
               t.poses.begin() + static_cast<std::ptrdiff_t>(segment.last_pose));
    const bool measured = all.size() > first;
    for (std::size_t k = segment.first_node; k < segment.last_node && !measured; ++k) {
      if (!t.nodes[k].placed) continue;
      all.push_back(like);
      all.back().node = k;
      all.back().T_map_vehicle = t.nodes[k].T_map_vehicle;
    }
    segment.first_pose = first;
    segment.last_pose = all.size();
  }
  t.poses = std::move(all);
}

HeldStates HeldStates::headings(std::vector<Trajectory>* trajectories) {
  return {trajectories,
          stands_in_the_plane,
          {.T_map_vehicle = {},
           .position_sigma_m = INFINITY,
           .heading_sigma_rad = kHeadingHeldToRad,
           .attitude_sigma_rad = INFINITY}};
}

HeldStates HeldStates::paths(std::vector<Trajectory>& trajectories, double place_m, double attitude_rad) {
  return {&trajectories,
          can_be_held,
          {.T_map_vehicle = {},
           .position_sigma_m = place_m,
           .heading_sigma_rad = attitude_rad,
           .attitude_sigma_rad = attitude_rad}};
}

bool can_be_held(const Trajectory& t) {
  return t.moving && t.motion == Motion::kSpatial && !t.odometry.empty() && t.poses.empty() &&
         !t.motion_prior;
}

}  // namespace octant::calib
