// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/trajectory_buffer.h"

namespace octant::calib {
namespace {

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<Pose> auto&& T) {
  buffer.exchange(T.translation_m, T.rotation.coeffs());
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<Node> auto&& node) {
  exchange(buffer, node.T_map_vehicle);
  buffer.exchange(node.cycle_offset_s, node.velocity, node.placed, node.time_s, node.epoch);
}

/// An arrival of a vehicle, and what of its observation does not follow from it.
template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<ArrivalObservation> auto&& o, BufferRecord<Arrival> auto&& a) {
  buffer.exchange(o.node, o.rejection, o.alpha, o.model_speed_mps, o.sigma_s);
  buffer.exchange(a.time_s, a.tof_s, a.amplitude_v, a.temperature_degC, a.beacon.value, a.receiver.value,
                  a.epoch, a.line);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<BearingObservation> auto&& o) {
  buffer.exchange(o.node, o.bearing, o.rejection, o.reflector.value, o.alpha, o.bearing_rad, o.sigma_rad);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<PoseObservation> auto&& o) {
  exchange(buffer, o.T_map_vehicle);
  buffer.exchange(o.node, o.alpha, o.position_sigma_m, o.heading_sigma_rad, o.attitude_sigma_rad);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<OdometryObservation> auto&& o) {
  exchange(buffer, o.T_before_after);
  buffer.exchange(o.node, o.distance_sigma_m, o.heading_sigma_rad);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<MotionObservation> auto&& o) {
  buffer.exchange(o.node, o.step_s);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<Segment> auto&& s) {
  buffer.exchange(s.first_node, s.last_node, s.first_arrival, s.last_arrival, s.first_bearing, s.last_bearing,
                  s.first_pose, s.last_pose, s.first_odometry, s.last_odometry, s.first_motion,
                  s.last_motion);
}

template <class Record>
void write_list(const std::vector<Record>& list, BufferWriter& buffer) {
  buffer.put_count(list.size());
  for (const Record& record : list) exchange(buffer, record);
}

/// Reads records behind those that a list holds, and hands each to `renumber`.
template <class Record, class Renumber>
void read_list(BufferReader& buffer, std::vector<Record>& list, Renumber&& renumber) {
  for (std::size_t n = buffer.count(); n > 0; --n) {
    exchange(buffer, list.emplace_back());
    renumber(list.back());
  }
}

/// Moves the ranges of a segment behind what the lists hold.
void move_behind(const Trajectory& to, Segment& s) {
  s.first_node += to.nodes.size(), s.last_node += to.nodes.size();
  s.first_arrival += to.arrivals.size(), s.last_arrival += to.arrivals.size();
  s.first_bearing += to.bearings.size(), s.last_bearing += to.bearings.size();
  s.first_pose += to.poses.size(), s.last_pose += to.poses.size();
  s.first_odometry += to.odometry.size(), s.last_odometry += to.odometry.size();
  s.first_motion += to.motion_steps.size(), s.last_motion += to.motion_steps.size();
}

}  // namespace

void write_trajectory(const Trajectory& t, const std::vector<Arrival>& rows, BufferWriter& buffer) {
  buffer.exchange(t.moving, t.motion_prior.has_value(), t.nominal_speed_mps);
  write_list(t.segments, buffer);
  buffer.put_count(t.arrivals.size());
  for (const ArrivalObservation& o : t.arrivals) {
    exchange(buffer, o, rows[o.arrival]);
    if (o.two_way) exchange(buffer, t.T_hear_send[static_cast<std::size_t>(o.hear_send)]);
  }
  write_list(t.bearings, buffer);
  write_list(t.poses, buffer);
  write_list(t.odometry, buffer);
  write_list(t.motion_steps, buffer);
  write_list(t.nodes, buffer);
}

void read_trajectory(const TrajectoryModel& model, BufferReader& buffer, Trajectory& to,
                     std::vector<Arrival>& rows) {
  to.motion = model.motion;
  to.has_cycle_offset = model.timing.clock == Clock::kCycleOffset;
  to.turnaround_s = model.timing.turnaround_s;
  bool has_motion_prior = false;
  buffer.exchange(to.moving, has_motion_prior, to.nominal_speed_mps);
  if (has_motion_prior) to.motion_prior = model.motion_priors[to.vehicle.index()];
  read_list(buffer, to.segments, [&to](Segment& s) { move_behind(to, s); });
  const std::size_t nodes = to.nodes.size();
  for (std::size_t n = buffer.count(); n > 0; --n) {
    ArrivalObservation kept;
    Arrival& a = rows.emplace_back();
    a.vehicle = to.vehicle;
    exchange(buffer, kept, a);
    ArrivalObservation& o = to.arrivals.emplace_back(observe(a, model, kept.model_speed_mps));
    o.node = kept.node + static_cast<std::uint32_t>(nodes);
    o.arrival = static_cast<std::uint32_t>(rows.size() - 1);
    o.alpha = kept.alpha;
    o.sigma_s = kept.sigma_s;
    o.rejection = kept.rejection;
    if (!o.two_way) continue;
    o.hear_send = static_cast<std::int32_t>(to.T_hear_send.size());
    exchange(buffer, to.T_hear_send.emplace_back());
  }
  const auto behind_nodes = [nodes](auto& o) { o.node += nodes; };
  read_list(buffer, to.bearings, behind_nodes);
  read_list(buffer, to.poses, behind_nodes);
  read_list(buffer, to.odometry, behind_nodes);
  read_list(buffer, to.motion_steps, behind_nodes);
  read_list(buffer, to.nodes, [](Node&) {});
}

}  // namespace octant::calib
