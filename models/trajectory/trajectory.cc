// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/trajectory.h"

#include <algorithm>
#include <cmath>

namespace octant {

ArrivalObservation observe(const Arrival& a, const TrajectoryModel& model, double model_speed_mps) {
  ArrivalObservation o;
  o.beacon = a.beacon;
  o.receiver = a.receiver;
  o.time_s = a.time_s;
  o.tof_s = a.tof_s;
  o.sigma_s = model.noise.tof_sigma_s;
  o.model_speed_mps = model_speed_mps;
  if (model.attenuation && model.attenuation->measures(a.amplitude_v)) {
    o.log_amplitude = std::log(a.amplitude_v);
    o.log_amplitude_sigma = model.noise.amplitude_relative_sigma;
    if (model.attenuation->directional()) {
      // The walk follows from the measured amplitude. It is strongly nonlinear near the threshold, so an
      // overestimated amplitude must not appear exact.
      const double least_v = a.amplitude_v * std::max(1 - o.log_amplitude_sigma, 0.5);
      o.sigma_s =
          std::hypot(o.sigma_s, walk_by_log_amplitude_s(least_v, *model.attenuation) * o.log_amplitude_sigma);
    }
  }
  o.two_way = model.timing.ranging == Ranging::kTwoWay;
  return o;
}

double speed_of(const Arrival& a, const TrajectoryModel& model) {
  return speed_mps(model.medium,
                   std::isfinite(a.temperature_degC) ? a.temperature_degC : model.medium.temperature_degC);
}

StateSpace state_space(VehicleId vehicle, const TrajectoryModel& model) {
  StateSpace states;
  states.vehicle = vehicle;
  states.motion = model.motion;
  states.has_cycle_offset = model.timing.clock == Clock::kCycleOffset;
  states.turnaround_s = model.timing.turnaround_s;
  states.nominal_speed_mps = speed_mps(model.medium, model.medium.temperature_degC);
  return states;
}

void reserve_epoch(Trajectory& t, std::size_t arrivals, std::size_t bearings) {
  t.nodes.reserve(1);
  t.segments.reserve(1);
  t.T_hear_send.reserve(1);
  t.arrivals.reserve(arrivals);
  t.bearings.reserve(bearings);
}

void set_epoch(Trajectory& t, std::span<const Arrival> arrivals, std::span<const Bearing> bearings,
               const TrajectoryModel& model) {
  static_cast<StateSpace&>(t) =
      state_space(arrivals.empty() ? bearings.front().vehicle : arrivals.front().vehicle, model);
  Node node;
  node.time_s = arrivals.empty() ? bearings.front().time_s : arrivals.front().time_s;
  node.epoch = arrivals.empty() ? bearings.front().epoch : arrivals.front().epoch;
  t.nodes.assign(1, node);
  t.T_hear_send.assign(1, Pose());
  t.arrivals.clear();
  t.bearings.clear();
  for (const Arrival& a : arrivals) {
    t.arrivals.push_back(observe(a, model, speed_of(a, model)));
    t.arrivals.back().arrival = t.arrivals.size() - 1;
    if (t.arrivals.back().two_way) t.arrivals.back().hear_send = 0;
  }
  for (const Bearing& b : bearings)
    t.bearings.push_back({0, 0.0, t.bearings.size(), b.reflector, b.bearing_rad,
                          model.noise.bearing_sigma_rad, Rejection::kUsed});
  set_only_segment(t);
}

Trajectory standing_at(const Trajectory& like, const Node& node) {
  Trajectory t;
  static_cast<StateSpace&>(t) = like;
  t.moving = false;
  t.motion_prior.reset();
  t.nodes = {node};
  return t;
}

void set_only_segment(Trajectory& t) {
  t.segments.assign(1, {.last_node = t.nodes.size()});
  for_each_list([&t](auto list, auto, auto last) { t.segments.front().*last = (t.*list).size(); });
}

bool interpolate_poses(const std::vector<TimedPose>& poses, double time_s, double max_gap_s,
                       Pose& T_map_vehicle) {
  const auto after = std::ranges::lower_bound(poses, time_s, {}, &TimedPose::time_s);
  if (after == poses.end()) return false;
  if (after->time_s == time_s) {
    T_map_vehicle = after->T_map_vehicle;
    return true;
  }
  if (after == poses.begin()) return false;
  const auto before = after - 1;
  const double span = after->time_s - before->time_s;
  if (span > max_gap_s) return false;
  T_map_vehicle = interpolate(before->T_map_vehicle, after->T_map_vehicle, (time_s - before->time_s) / span);
  return true;
}

}  // namespace octant
