// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/cold_start.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/problem/ranges.h"
#include "models/support/observed.h"

namespace octant::calib {
namespace {

/// Initial height of an overhead beacon above the receivers, as a fraction of the typical range.
constexpr double kHeightShare = 0.2;
constexpr std::size_t kReceiversForBearing = 3;

/// Range and horizontal bearing of one beacon from one epoch, in the vehicle frame.
struct BeaconSight {
  BeaconId beacon;
  double range_m = 0.0;
  double bearing_rad = 0.0;
};

/// A plane wave over the array: range_i = range - o_i . u, solved for range and the horizontal u.
bool sight_of(const std::vector<std::pair<Eigen::Vector3d, double>>& receivers, BeaconSight& sight) {
  if (receivers.size() < kReceiversForBearing) return false;
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const auto& [o, range_m] : receivers) {
    const Eigen::Vector3d row(1.0, -o.x(), -o.y());
    N += row * row.transpose();
    b += row * range_m;
  }
  const ObservedState<Eigen::Matrix3d> observed(N);
  if (!observed.all()) return false;
  const Eigen::Vector3d solution = observed.solve(b);
  sight.range_m = solution[0];
  sight.bearing_rad = std::atan2(solution[2], solution[1]);
  return true;
}

std::vector<BeaconSight> sights_of(const Trajectory& t, const Segment& segment, const SharedState& state) {
  std::map<BeaconId, std::vector<std::pair<Eigen::Vector3d, double>>> heard;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.node == segment.first_node)
      heard[a.beacon].emplace_back(state.receiver_p_vehicle_m[a.receiver.index()],
                                   prior_range_m(t, a, state));
  }
  std::vector<BeaconSight> sights;
  for (const auto& [beacon, receivers] : heard) {
    BeaconSight sight{beacon, 0.0, 0.0};
    if (sight_of(receivers, sight)) sights.push_back(sight);
  }
  return sights;
}

}  // namespace

ColdStart start_from_array(const Problem& problem, SharedState& state, std::vector<Trajectory>& trajectories,
                           std::vector<bool>& beacon_found, double typical_range_m) {
  ColdStart result;
  Trajectory* best_trajectory = nullptr;
  const Segment* best_segment = nullptr;
  std::vector<BeaconSight> best;
  for (Trajectory& t : trajectories) {
    if (t.moving || t.has_cycle_offset) continue;  // an unknown offset hides the range
    for (const Segment& segment : t.segments) {
      std::vector<BeaconSight> sights = sights_of(t, segment, state);
      if (sights.size() <= best.size()) continue;
      best = std::move(sights);
      best_trajectory = &t;
      best_segment = &segment;
    }
  }
  if (best.size() < 2 || best_segment == nullptr) return result;
  double receiver_z_m = 0.0;
  for (const Eigen::Vector3d& o : state.receiver_p_vehicle_m)
    receiver_z_m += o.z() / static_cast<double>(state.receiver_p_vehicle_m.size());
  for (const BeaconSight& sight : best) {
    const SiteBeacon& known = problem.site.beacons[sight.beacon.index()];
    const double above_m = known.position_m[2]
                               ? *known.position_m[2] - receiver_z_m
                               : std::min(kHeightShare * typical_range_m, 0.7 * sight.range_m);
    const double across_m = std::sqrt(std::max(0.0, sight.range_m * sight.range_m - above_m * above_m));
    state.beacon_p_map_m[sight.beacon.index()] = {across_m * std::cos(sight.bearing_rad),
                                                  across_m * std::sin(sight.bearing_rad),
                                                  receiver_z_m + above_m};
    beacon_found[sight.beacon.index()] = true;
  }
  Node& node = best_trajectory->nodes[best_segment->first_node];
  node.T_map_vehicle = Pose();
  node.placed = true;
  // Bearings of a small array are good to some degrees, heights are a guess.
  result.uncertainty_m = 0.1 * typical_range_m;
  result.ok = true;
  return result;
}

ColdStart start_from_odometry(const Problem& problem, std::vector<Trajectory>& trajectories) {
  ColdStart result;
  Trajectory* longest = nullptr;
  for (Trajectory& t : trajectories)
    if (!t.odometry.empty() && (longest == nullptr || t.odometry.size() > longest->odometry.size()))
      longest = &t;
  if (longest == nullptr) return result;
  double distance_variance = 0.0, heading_variance = 0.0, path_m = 0.0;
  longest->nodes[longest->odometry.front().node].T_map_vehicle = Pose();
  longest->nodes[longest->odometry.front().node].placed = true;
  for (const OdometryObservation& o : longest->odometry) {
    longest->nodes[o.node + 1].T_map_vehicle = longest->nodes[o.node].T_map_vehicle * o.T_before_after;
    longest->nodes[o.node + 1].placed = true;
    distance_variance += o.distance_sigma_m * o.distance_sigma_m;
    heading_variance += o.heading_sigma_rad * o.heading_sigma_rad;
    path_m += o.T_before_after.translation_m.norm();
  }
  // A heading error that grows like a random walk bends the path by about a third of its size over the extent
  // of the site.
  Eigen::AlignedBox2d box;
  for (const Node& node : longest->nodes) box.extend(node.T_map_vehicle.translation_m.head<2>());
  result.uncertainty_m = std::sqrt(distance_variance + heading_variance * box.diagonal().squaredNorm() / 9);
  result.uncertainty_m = std::min(result.uncertainty_m, 0.1 * path_m);
  result.ok = path_m > 0 && problem.site.motion == Motion::kPlanar;
  return result;
}

}  // namespace octant::calib
