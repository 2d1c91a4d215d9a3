// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/motion_start.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "models/localizers/least_squares/epoch_fix.h"

namespace octant {
namespace {

/// Lengths of the windows [s], shortest first, because the vehicle moves least in them.
constexpr std::array<double, 6> kWindows_s = {0.0, 0.1, 0.25, 0.5, 1.0, 2.0};

struct Anchor {
  double time_s = 0.0;
  Pose T_map_vehicle;
  bool heading_known = false;
};

/// Arrivals of nodes [first, last) as observations of one vehicle at rest.
Trajectory standing(const Trajectory& t, const Segment& segment, std::size_t first, std::size_t last) {
  Trajectory piece = standing_at(
      t, {.time_s = 0.5 * (t.nodes[first].time_s + t.nodes[last - 1].time_s), .T_map_vehicle = {}});
  piece.T_hear_send = t.T_hear_send;
  const auto copy = [first, last](const auto& list, std::size_t begin, std::size_t end, auto& to) {
    for (std::size_t i = begin; i < end; ++i) {
      if (list[i].node < first || list[i].node >= last) continue;
      to.push_back(list[i]);
      to.back().node = 0;
    }
  };
  copy(t.arrivals, segment.first_arrival, segment.last_arrival, piece.arrivals);
  copy(t.bearings, segment.first_bearing, segment.last_bearing, piece.bearings);
  set_only_segment(piece);
  return piece;
}

std::size_t node_after(const Trajectory& t, const Segment& segment, std::size_t first, double span_s) {
  std::size_t last = first + 1;
  while (last < segment.last_node && t.nodes[last].time_s <= t.nodes[first].time_s + span_s) ++last;
  return last;
}

std::vector<Anchor> find_anchors(const Trajectory& t, const Segment& segment, const EpochFixModel& model,
                                 const TrackerOptions& options) {
  std::vector<Anchor> anchors;
  // Arrivals are sorted by node, so a window begins where the previous one ended.
  Segment rest = segment;
  for (std::size_t first = segment.first_node; first < segment.last_node;) {
    std::size_t next = first + 1;
    while (rest.first_arrival < rest.last_arrival && t.arrivals[rest.first_arrival].node < first)
      ++rest.first_arrival;
    for (const double span_s : kWindows_s) {
      const std::size_t last = node_after(t, segment, first, span_s);
      Segment window = rest;
      while (window.last_arrival > window.first_arrival && t.arrivals[window.last_arrival - 1].node >= last)
        --window.last_arrival;
      if (window.last_arrival - window.first_arrival < 2) continue;
      Trajectory piece = standing(t, window, first, last);
      EpochFixOptions search;
      search.range_uncertainty_m =
          std::hypot(options.range_uncertainty_m,
                     0.5 * t.motion_prior->speed_mps * (t.nodes[last - 1].time_s - t.nodes[first].time_s));
      search.rejection_sigmas = options.rejection_sigmas;
      search.max_sigma_m = INFINITY;
      const Fix fix = fix_epoch(piece, piece.segments.front(), model, search);
      if (!fix.ok()) continue;
      anchors.push_back({piece.nodes.front().time_s, fix.T_map_vehicle, fix.covariance(2, 2) < 1.0});
      next = last;
      break;
    }
    // A step of a tenth of a second is short enough for interpolation.
    first = std::max(next, node_after(t, segment, first, 0.1));
  }
  return anchors;
}

}  // namespace

bool place_by_motion(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                     const TrackerOptions& options) {
  const std::vector<Anchor> anchors = find_anchors(t, segment, model, options);
  if (anchors.empty()) return false;
  for (std::size_t k = segment.first_node; k < segment.last_node; ++k) {
    Node& node = t.nodes[k];
    const auto after = std::ranges::lower_bound(anchors, node.time_s, {}, &Anchor::time_s);
    const auto before = after == anchors.begin() ? after : after - 1;
    node.placed = true;
    if (after == anchors.end() || before == after || after->time_s <= before->time_s) {
      node.T_map_vehicle = (after == anchors.end() ? anchors.back() : *after).T_map_vehicle;
      node.velocity.setZero();
      continue;
    }
    const double span_s = after->time_s - before->time_s;
    node.T_map_vehicle =
        interpolate(before->T_map_vehicle, after->T_map_vehicle, (node.time_s - before->time_s) / span_s);
    node.velocity = (after->T_map_vehicle.translation_m - before->T_map_vehicle.translation_m) / span_s;
    const bool turning = before->heading_known && after->heading_known;
    node.velocity[2] =
        turning
            ? wrap_angle(after->T_map_vehicle.heading_rad() - before->T_map_vehicle.heading_rad()) / span_s
            : 0.0;
    // Poses of neighbouring windows differ by their uncertainty, which must not appear as a velocity.
    const double speed_mps = node.velocity.head<2>().norm();
    if (speed_mps > 2 * t.motion_prior->speed_mps)
      node.velocity.head<2>() *= 2 * t.motion_prior->speed_mps / speed_mps;
  }
  return true;
}

}  // namespace octant
