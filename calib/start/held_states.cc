// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/held_states.h"

#include <cmath>
#include <utility>

namespace octant::calib {

HeldStates::HeldStates(std::vector<Trajectory>* trajectories) : trajectories_(trajectories) {
  if (trajectories == nullptr) return;
  for (const Trajectory& t : *trajectories) {
    poses_.push_back(t.poses);
    segments_.push_back(t.segments);
  }
}

HeldStates::~HeldStates() {
  if (trajectories_ == nullptr) return;
  for (std::size_t i = 0; i < trajectories_->size(); ++i) {
    (*trajectories_)[i].poses = std::move(poses_[i]);
    (*trajectories_)[i].segments = std::move(segments_[i]);
  }
}

void HeldStates::hold(const Trajectory& t, Segment& segment, const PoseObservation& like,
                      std::vector<PoseObservation>& all) {
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

HeldHeadings::HeldHeadings(std::vector<Trajectory>* trajectories) : HeldStates(trajectories) {
  if (trajectories == nullptr) return;
  constexpr double kHeldToRad = 0.1;  // what the search leaves with beacons off by a few decimetres
  for (Trajectory& t : *trajectories) {
    if (t.moving || t.motion != Motion::kPlanar) continue;
    std::vector<PoseObservation> all;
    for (Segment& segment : t.segments)
      hold(t, segment,
           {.T_map_vehicle = {},
            .position_sigma_m = INFINITY,
            .heading_sigma_rad = kHeldToRad,
            .attitude_sigma_rad = INFINITY},
           all);
    t.poses = std::move(all);
  }
}

bool can_be_held(const Trajectory& t) {
  return t.moving && t.motion == Motion::kSpatial && !t.odometry.empty() && t.poses.empty() &&
         !t.motion_prior;
}

HeldPaths::HeldPaths(std::vector<Trajectory>& trajectories, double place_m, double attitude_rad)
    : HeldStates(&trajectories) {
  for (Trajectory& t : trajectories) {
    if (!can_be_held(t)) continue;
    std::vector<PoseObservation> all;
    for (Segment& segment : t.segments)
      hold(t, segment,
           {.T_map_vehicle = {},
            .position_sigma_m = place_m,
            .heading_sigma_rad = attitude_rad,
            .attitude_sigma_rad = attitude_rad},
           all);
    t.poses = std::move(all);
  }
}

}  // namespace octant::calib
