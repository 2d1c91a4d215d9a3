// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/trajectory_buffer.h"

#include "calib/adjust/node_buffer.h"

namespace octant::calib {

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<BearingObservation> auto&& o) {
  buffer.exchange(o.node, o.bearing, o.rejection, o.reflector.value, o.alpha, o.bearing_rad, o.sigma_rad);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<PoseObservation> auto&& o) {
  buffer.exchange(o.T_map_vehicle, o.node, o.alpha, o.position_sigma_m, o.heading_sigma_rad,
                  o.attitude_sigma_rad);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<OdometryObservation> auto&& o) {
  buffer.exchange(o.T_before_after, o.node, o.distance_sigma_m, o.heading_sigma_rad);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<MotionObservation> auto&& o) {
  buffer.exchange(o.node, o.step_s);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<Segment> auto&& s) {
  buffer.exchange(s.first_node, s.last_node);
  for_each_list([&](auto, auto first, auto last) { buffer.exchange(s.*first, s.*last); });
}

namespace {

/// An arrival of a vehicle, and what of its observation does not follow from it.
template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<ArrivalObservation> auto&& o, BufferRecord<Arrival> auto&& a) {
  buffer.exchange(o.node, o.rejection, o.alpha, o.model_speed_mps, o.sigma_s);
  buffer.exchange(a.time_s, a.tof_s, a.amplitude_v, a.temperature_degC, a.beacon.value, a.receiver.value,
                  a.epoch, a.line);
}

/// All but the arrivals.
template <class Buffer>
void exchange_lists(Buffer& buffer, BufferRecord<Trajectory> auto&& t) {
  buffer.exchange(t.segments, t.bearings, t.poses, t.odometry, t.motion_steps, t.nodes);
}

/// Moves the states, observations and segments of a part behind those that a trajectory has.
void append_states(const Trajectory& part, Trajectory& to) {
  const std::size_t nodes = to.nodes.size();
  for (Segment s : part.segments) {
    s.first_node += nodes, s.last_node += nodes;
    for_each_list([&](auto list, auto first, auto last) {
      s.*first += (to.*list).size(), s.*last += (to.*list).size();
    });
    to.segments.push_back(s);
  }
  for_each_list([&](auto list, auto, auto) {
    for (auto o : part.*list) {
      o.node = static_cast<decltype(o.node)>(o.node + nodes);
      (to.*list).push_back(o);
    }
  });
  to.nodes.insert(to.nodes.end(), part.nodes.begin(), part.nodes.end());
}

}  // namespace

void write_trajectory(const Trajectory& t, const std::vector<Arrival>& rows, BufferWriter& buffer) {
  buffer.exchange(t.moving, t.motion_prior.has_value(), t.nominal_speed_mps, t.arrivals.size());
  for (const ArrivalObservation& o : t.arrivals) {
    exchange(buffer, o, rows[o.arrival]);
    if (o.two_way) buffer.exchange(t.T_hear_send[static_cast<std::size_t>(o.hear_send)]);
  }
  exchange_lists(buffer, t);
}

void read_trajectory(const TrajectoryModel& model, BufferReader& buffer, Trajectory& to,
                     std::vector<Arrival>& rows) {
  to.motion = model.motion;
  to.has_cycle_offset = model.timing.clock == Clock::kCycleOffset;
  to.turnaround_s = model.timing.turnaround_s;
  bool has_motion_prior = false;
  std::size_t arrivals = 0;
  buffer.exchange(to.moving, has_motion_prior, to.nominal_speed_mps, arrivals);
  if (has_motion_prior) to.motion_prior = model.motion_priors[to.vehicle.index()];
  Trajectory part;
  for (; arrivals > 0; --arrivals) {
    ArrivalObservation kept;
    Arrival& a = rows.emplace_back();
    a.vehicle = to.vehicle;
    exchange(buffer, kept, a);
    ArrivalObservation& o = part.arrivals.emplace_back(observe(a, model, kept.model_speed_mps));
    o.node = kept.node;
    o.arrival = static_cast<std::uint32_t>(rows.size() - 1);
    o.alpha = kept.alpha;
    o.sigma_s = kept.sigma_s;
    o.rejection = kept.rejection;
    if (!o.two_way) continue;
    o.hear_send = static_cast<std::int32_t>(to.T_hear_send.size());
    buffer.exchange(to.T_hear_send.emplace_back());
  }
  exchange_lists(buffer, part);
  append_states(part, to);
}

}  // namespace octant::calib
