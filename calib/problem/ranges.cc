// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/ranges.h"

#include <algorithm>
#include <utility>

#include "models/trajectory/linearise.h"
#include "models/trajectory/observed_range.h"

namespace octant::calib {

double nth_smallest(std::vector<double> values, std::size_t n) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(n);
  std::ranges::nth_element(values, at);
  return *at;
}

double median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  return values.empty() ? 0.0 : nth_smallest(std::move(values), middle);
}

double quantile(std::vector<double> values, double share) {
  const auto below = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  return nth_smallest(std::move(values), below);
}

double prior_range_m(const Trajectory& t, const ArrivalObservation& a, const SharedState& state) {
  const Node& node = t.nodes[a.node];
  const auto offset_s = t.has_cycle_offset && node.placed ? std::optional(node.cycle_offset_s) : std::nullopt;
  return std::max(0.0, observed_range_m(t, a, state, offset_s));
}

std::vector<RangeFrom> ranges_to(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                 BeaconId beacon) {
  std::vector<RangeFrom> ranges;
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals)
      if (a.beacon == beacon && t.nodes[a.node].placed && (a.alpha == 0.0 || t.nodes[a.node + 1].placed))
        ranges.push_back({pose_at(t, a.node, a.alpha) * state.receiver_p_vehicle_m[a.receiver.index()],
                          prior_range_m(t, a, state)});
  return ranges;
}

namespace {

/// Sigma of a measured heading above which it does not determine a direction.
constexpr double kVagueHeadingRad = 0.5;

/// Returns true if more than the bearings of one beacon determine the heading of a planar state.
bool heading_is_observable(const Trajectory& t, const Segment& segment, std::size_t node, BeaconId but,
                           const std::vector<bool>& known) {
  if (!t.odometry.empty() || t.motion_prior) return true;
  for (std::size_t i = segment.first_pose; i < segment.last_pose; ++i)
    if (t.poses[i].node == node && t.poses[i].heading_sigma_rad < kVagueHeadingRad) return true;
  for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i) {
    const BeaconId reflector = t.bearings[i].reflector;
    if (t.bearings[i].node == node && reflector.valid() && reflector != but && known[reflector.index()])
      return true;
  }
  ReceiverId first;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.node != node || a.beacon == but || !known[a.beacon.index()]) continue;
    if (!first.valid()) first = a.receiver;
    if (a.receiver != first) return true;
  }
  return false;
}

}  // namespace

std::vector<RayFrom> rays_to(const std::vector<Trajectory>& trajectories, BeaconId beacon,
                             const std::vector<bool>& known) {
  std::vector<RayFrom> rays;
  for (const Trajectory& t : trajectories) {
    if (t.motion != Motion::kPlanar) continue;
    for (const Segment& segment : t.segments)
      for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i) {
        const BearingObservation& b = t.bearings[i];
        if (b.reflector != beacon || !t.nodes[b.node].placed ||
            (b.alpha != 0.0 && !t.nodes[b.node + 1].placed))
          continue;
        if (!heading_is_observable(t, segment, b.node, beacon, known)) continue;
        const Pose T = pose_at(t, b.node, b.alpha);
        rays.push_back({T.translation_m.head<2>(), wrap_angle(T.heading_rad() + b.bearing_rad), b.sigma_rad});
      }
  }
  return rays;
}

double typical_range_m(const Site& site, const std::vector<Trajectory>& trajectories) {
  constexpr std::size_t kEnough = 50000;
  const SharedState prior = prior_state(site);
  std::vector<double> ranges;
  for_each_spread_arrival(trajectories, kEnough, [&](const Trajectory& t, const ArrivalObservation& a) {
    ranges.push_back(prior_range_m(t, a, prior));
  });
  return ranges.empty() ? 1.0 : std::max(median(std::move(ranges)), 1e-3);
}

}  // namespace octant::calib
