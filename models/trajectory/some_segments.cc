// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/trajectory.h"

namespace octant {

Trajectory some_segments(const Trajectory& t, std::size_t every) {
  if (every == 1) return t;
  Trajectory few;
  few.run = t.run;
  few.vehicle = t.vehicle;
  few.motion = t.motion;
  few.has_cycle_offset = t.has_cycle_offset;
  few.moving = t.moving;
  few.nominal_speed_mps = t.nominal_speed_mps;
  few.turnaround_s = t.turnaround_s;
  few.T_hear_send = t.T_hear_send;
  few.motion_prior = t.motion_prior;
  for (std::size_t s = 0; s < t.segments.size(); s += every) {
    const Segment& from = t.segments[s];
    Segment to;
    const std::size_t shift = few.nodes.size() - from.first_node;  // modulo 2^n, as is the sum below
    const auto take = [&](const auto& all, auto& some, std::size_t first, std::size_t last,
                          std::size_t& to_first, std::size_t& to_last) {
      to_first = some.size();
      some.insert(some.end(), all.begin() + static_cast<std::ptrdiff_t>(first),
                  all.begin() + static_cast<std::ptrdiff_t>(last));
      to_last = some.size();
    };
    take(t.nodes, few.nodes, from.first_node, from.last_node, to.first_node, to.last_node);
    take(t.arrivals, few.arrivals, from.first_arrival, from.last_arrival, to.first_arrival, to.last_arrival);
    take(t.bearings, few.bearings, from.first_bearing, from.last_bearing, to.first_bearing, to.last_bearing);
    take(t.poses, few.poses, from.first_pose, from.last_pose, to.first_pose, to.last_pose);
    take(t.odometry, few.odometry, from.first_odometry, from.last_odometry, to.first_odometry,
         to.last_odometry);
    take(t.motion_steps, few.motion_steps, from.first_motion, from.last_motion, to.first_motion,
         to.last_motion);
    for (std::size_t i = to.first_arrival; i < to.last_arrival; ++i) few.arrivals[i].node += shift;
    for (std::size_t i = to.first_bearing; i < to.last_bearing; ++i) few.bearings[i].node += shift;
    for (std::size_t i = to.first_pose; i < to.last_pose; ++i) few.poses[i].node += shift;
    for (std::size_t i = to.first_odometry; i < to.last_odometry; ++i) few.odometry[i].node += shift;
    for (std::size_t i = to.first_motion; i < to.last_motion; ++i) few.motion_steps[i].node += shift;
    few.segments.push_back(to);
  }
  return few;
}

}  // namespace octant
