// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "models/trajectory/stretches.h"

namespace octant {

Segment stretch_of(const Trajectory& t, const Segment& segment, std::size_t first_node,
                   std::size_t last_node) {
  Segment out = segment;
  out.first_node = first_node;
  out.last_node = last_node;
  // The last node carries no observation that reaches beyond it, so those on it with alpha > 0 are out as
  // well.
  const auto narrow = [&](const auto& list, std::size_t& first, std::size_t& last) {
    const auto begin = list.begin();
    const auto from = std::partition_point(begin + static_cast<std::ptrdiff_t>(first),
                                           begin + static_cast<std::ptrdiff_t>(last),
                                           [&](const auto& o) { return o.node < first_node; });
    const auto to = std::partition_point(from, begin + static_cast<std::ptrdiff_t>(last),
                                         [&](const auto& o) { return o.node + 1 < last_node; });
    first = static_cast<std::size_t>(from - begin);
    last = static_cast<std::size_t>(to - begin);
  };
  narrow(t.arrivals, out.first_arrival, out.last_arrival);
  narrow(t.bearings, out.first_bearing, out.last_bearing);
  narrow(t.poses, out.first_pose, out.last_pose);
  narrow(t.odometry, out.first_odometry, out.last_odometry);
  narrow(t.motion_steps, out.first_motion, out.last_motion);
  return out;
}

Trajectory pick_segments(const Trajectory& t, const std::vector<Segment>& segments) {
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
  for (const Segment& from : segments) {
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
    for (std::size_t i = to.first_arrival; i < to.last_arrival; ++i)
      few.arrivals[i].node = static_cast<std::uint32_t>(few.arrivals[i].node + shift);
    for (std::size_t i = to.first_bearing; i < to.last_bearing; ++i) few.bearings[i].node += shift;
    for (std::size_t i = to.first_pose; i < to.last_pose; ++i) few.poses[i].node += shift;
    for (std::size_t i = to.first_odometry; i < to.last_odometry; ++i) few.odometry[i].node += shift;
    for (std::size_t i = to.first_motion; i < to.last_motion; ++i) few.motion_steps[i].node += shift;
    few.segments.push_back(to);
  }
  return few;
}

std::vector<Segment> spread_stretches(const Trajectory& t, const Segment& segment, std::size_t count,
                                      std::size_t nodes) {
  std::vector<Segment> out;
  const std::size_t all = segment.last_node - segment.first_node;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = segment.first_node + i * all / count;
    out.push_back(stretch_of(t, segment, first, std::min(segment.last_node, first + nodes)));
  }
  return out;
}

std::vector<Segment> with_chains_cut(const Trajectory& t) {
  std::vector<Segment> all;
  for (const Segment& s : t.segments) {
    if (!is_long_chain(s)) {
      all.push_back(s);
      continue;
    }
    for (std::size_t first = s.first_node; first < s.last_node; first += kStretchNodes)
      all.push_back(stretch_of(t, s, first, std::min(s.last_node, first + kStretchNodes)));
  }
  return all;
}

Trajectory some_segments(const Trajectory& t, std::size_t stride) {
  if (stride == 1) return t;
  const std::vector<Segment> all = with_chains_cut(t);
  std::vector<Segment> some;
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  return pick_segments(t, some);
}

}  // namespace octant
