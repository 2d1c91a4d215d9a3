// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/fix_shift.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

constexpr std::size_t kPlaces = 30;

/// Paths of the log, each with one of its observations.
struct Paths {
  std::map<std::pair<std::size_t, std::size_t>, ArrivalObservation> arrivals;  ///< beacon, receiver
  std::map<std::size_t, BearingObservation> bearings;                          ///< reflector
  std::map<std::size_t, double> reach_m;  ///< horizontal reach of each beacon
};

double reach_to_m(const Trajectory& t, std::size_t node, const SharedState& state, BeaconId beacon) {
  return (state.beacon_p_map_m[beacon.index()] - t.nodes[node].T_map_vehicle.translation_m).head<2>().norm();
}

Paths paths_of(const Trajectory& t, const SharedState& state) {
  Paths paths;
  for (const ArrivalObservation& a : t.arrivals) {
    if (a.rejection != Rejection::kUsed || !t.nodes[a.node].placed) continue;
    paths.arrivals.emplace(std::pair(a.beacon.index(), a.receiver.index()), a);
    double& reach_m = paths.reach_m[a.beacon.index()];
    reach_m = std::max(reach_m, reach_to_m(t, a.node, state, a.beacon));
  }
  for (const BearingObservation& b : t.bearings) {
    if (b.rejection != Rejection::kUsed || !b.reflector.valid() || !t.nodes[b.node].placed) continue;
    paths.bearings.emplace(b.reflector.index(), b);
    double& reach_m = paths.reach_m[b.reflector.index()];
    reach_m = std::max(reach_m, reach_to_m(t, b.node, state, b.reflector));
  }
  return paths;
}

/// Vehicle at rest at a node that receives what x predicts.
Trajectory hearing_at(const Trajectory& t, std::size_t node, const Paths& paths, const SharedState& here) {
  Trajectory stop = standing_at(t, t.nodes[node]);
  stop.T_hear_send = {Pose()};
  for (const auto& [path, heard] : paths.arrivals) {
    if (reach_to_m(t, node, here, heard.beacon) > paths.reach_m.at(path.first)) continue;
    ArrivalObservation a = heard;
    a.node = 0;
    a.alpha = 0.0;
    a.hear_send = a.two_way ? 0 : -1;
    a.log_amplitude_sigma = 0.0;
    a.tof_s = 0.0;
    stop.arrivals.push_back(a);
    stop.arrivals.back().tof_s = -a.sigma_s * arrival_residual(stop, a, here);
  }
  for (const auto& [reflector, seen] : paths.bearings) {
    if (reach_to_m(t, node, here, seen.reflector) > paths.reach_m.at(reflector)) continue;
    stop.bearings.push_back(seen);
    BearingObservation& b = stop.bearings.back();
    b.node = 0;
    b.alpha = 0.0;
    b.bearing_rad = 0.0;
    ObservationRow row;
    if (bearing_rows(stop, stop.bearings.size() - 1, here, &row) > 0)
      b.bearing_rad = -b.sigma_rad * row.residual;
  }
  set_only_segment(stop);
  return stop;
}

/// Returns true if the observations of a stop determine more than an arc.
bool determines_a_place(const Trajectory& stop) {
  std::vector<std::size_t> beacons;
  for (const ArrivalObservation& a : stop.arrivals) beacons.push_back(a.beacon.index());
  for (const BearingObservation& b : stop.bearings) beacons.push_back(b.reflector.index());
  std::ranges::sort(beacons);
  beacons.erase(std::unique(beacons.begin(), beacons.end()), beacons.end());
  return beacons.size() >= (stop.has_cycle_offset ? 4U : 3U) ||
         (beacons.size() == 2 && !stop.has_cycle_offset);
}

}  // namespace

std::optional<double> fix_shift_m(const ParameterLayout& layout, const Eigen::VectorXd& x,
                                  const Eigen::VectorXd& y, const std::vector<Trajectory>& trajectories) {
  const SharedState here = layout.state_of(x), there = layout.state_of(y);
  double squares = 0.0;
  std::size_t places = 0;
  for (const Trajectory& t : trajectories) {
    const Paths paths = paths_of(t, here);
    double lever_m = 0.0;
    for (const auto& [path, heard] : paths.arrivals)
      lever_m = std::max(lever_m, here.receiver_p_vehicle_m[path.second].head<2>().norm());
    const std::size_t step = std::max<std::size_t>(1, t.nodes.size() / kPlaces);
    for (std::size_t k = step / 2; k < t.nodes.size(); k += step) {
      if (!t.nodes[k].placed) continue;
      Trajectory stop = hearing_at(t, k, paths, here);
      if (!determines_a_place(stop)) continue;
      solve_states(stop, stop.segments.front(), there, {});
      const Pose &was = t.nodes[k].T_map_vehicle, &is = stop.nodes.front().T_map_vehicle;
      const double turn_m =
          t.motion == Motion::kPlanar ? lever_m * wrap_angle(is.heading_rad() - was.heading_rad()) : 0.0;
      squares += (is.translation_m - was.translation_m).head<2>().squaredNorm() + turn_m * turn_m;
      ++places;
    }
  }
  if (places == 0) return std::nullopt;
  return std::sqrt(squares / static_cast<double>(places));
}

}  // namespace octant::calib
