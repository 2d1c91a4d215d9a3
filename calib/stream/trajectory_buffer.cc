// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/trajectory_buffer.h"

#include "calib/adjust/node_numbers.h"

namespace octant::calib {
namespace {

void put_node(const Node& node, BufferWriter& buffer) {
  double numbers[kNumbersOfNode];
  put_numbers(node, numbers);
  for (const double number : numbers) buffer.put(number);
  buffer.put(node.time_s);
  buffer.put_integer(node.epoch);
}
Node get_node(BufferReader& buffer) {
  double numbers[kNumbersOfNode];
  for (double& number : numbers) number = buffer.get();
  Node node;
  read_numbers(numbers, node);
  node.time_s = buffer.get();
  node.epoch = buffer.integer();
  return node;
}

void put_pose(const Pose& T, BufferWriter& buffer) {
  for (Eigen::Index i = 0; i < 3; ++i) buffer.put(T.translation_m[i]);
  for (Eigen::Index i = 0; i < 4; ++i) buffer.put(T.rotation.coeffs()[i]);
}
Pose get_pose(BufferReader& buffer) {
  Pose T;
  for (Eigen::Index i = 0; i < 3; ++i) T.translation_m[i] = buffer.get();
  for (Eigen::Index i = 0; i < 4; ++i) T.rotation.coeffs()[i] = buffer.get();
  return T;
}

void put_arrival(const ArrivalObservation& o, const Arrival& a, BufferWriter& buffer) {
  buffer.put_count(o.node);
  buffer.put_count(static_cast<std::size_t>(o.rejection));
  for (const double number :
       {o.alpha, o.model_speed_mps, o.sigma_s, a.time_s, a.tof_s, a.amplitude_v, a.temperature_degC})
    buffer.put(number);
  buffer.put_count(a.beacon.index());
  buffer.put_count(a.receiver.index());
  buffer.put_integer(a.epoch);
  buffer.put_integer(a.line);
}
ArrivalObservation get_arrival(const TrajectoryModel& model, VehicleId vehicle, BufferReader& buffer,
                               Arrival& a) {
  const std::size_t node = buffer.count();
  const auto rejection = static_cast<Rejection>(buffer.count());
  const double alpha = buffer.get(), speed_mps = buffer.get(), sigma_s = buffer.get();
  for (double* number : {&a.time_s, &a.tof_s, &a.amplitude_v, &a.temperature_degC}) *number = buffer.get();
  a.beacon = BeaconId(buffer.count());
  a.receiver = ReceiverId(buffer.count());
  a.vehicle = vehicle;
  a.epoch = buffer.integer();
  a.line = static_cast<int>(buffer.integer());
  ArrivalObservation o = observe(a, model, speed_mps);
  o.node = static_cast<std::uint32_t>(node);
  o.alpha = alpha;
  o.sigma_s = sigma_s;
  o.rejection = rejection;
  return o;
}

void put_bearing(const BearingObservation& o, BufferWriter& buffer) {
  for (const std::size_t count : {o.node, o.bearing, static_cast<std::size_t>(o.rejection)})
    buffer.put_count(count);
  buffer.put_integer(o.reflector.value);
  for (const double number : {o.alpha, o.bearing_rad, o.sigma_rad}) buffer.put(number);
}
BearingObservation get_bearing(BufferReader& buffer) {
  BearingObservation o;
  o.node = buffer.count();
  o.bearing = buffer.count();
  o.rejection = static_cast<Rejection>(buffer.count());
  o.reflector.value = static_cast<std::int32_t>(buffer.integer());
  for (double* number : {&o.alpha, &o.bearing_rad, &o.sigma_rad}) *number = buffer.get();
  return o;
}

void put_measured_pose(const PoseObservation& o, BufferWriter& buffer) {
  buffer.put_count(o.node);
  put_pose(o.T_map_vehicle, buffer);
  for (const double number : {o.alpha, o.position_sigma_m, o.heading_sigma_rad, o.attitude_sigma_rad})
    buffer.put(number);
}
PoseObservation get_measured_pose(BufferReader& buffer) {
  PoseObservation o;
  o.node = buffer.count();
  o.T_map_vehicle = get_pose(buffer);
  for (double* number : {&o.alpha, &o.position_sigma_m, &o.heading_sigma_rad, &o.attitude_sigma_rad})
    *number = buffer.get();
  return o;
}

void put_odometry(const OdometryObservation& o, BufferWriter& buffer) {
  buffer.put_count(o.node);
  put_pose(o.T_before_after, buffer);
  for (const double number : {o.distance_sigma_m, o.heading_sigma_rad}) buffer.put(number);
}
OdometryObservation get_odometry(BufferReader& buffer) {
  OdometryObservation o;
  o.node = buffer.count();
  o.T_before_after = get_pose(buffer);
  for (double* number : {&o.distance_sigma_m, &o.heading_sigma_rad}) *number = buffer.get();
  return o;
}

void put_segment(const Segment& s, BufferWriter& buffer) {
  for (const std::size_t count :
       {s.first_node, s.last_node, s.first_arrival, s.last_arrival, s.first_bearing, s.last_bearing,
        s.first_pose, s.last_pose, s.first_odometry, s.last_odometry, s.first_motion, s.last_motion})
    buffer.put_count(count);
}
Segment get_segment(BufferReader& buffer) {
  Segment s;
  for (std::size_t* count :
       {&s.first_node, &s.last_node, &s.first_arrival, &s.last_arrival, &s.first_bearing, &s.last_bearing,
        &s.first_pose, &s.last_pose, &s.first_odometry, &s.last_odometry, &s.first_motion, &s.last_motion})
    *count = buffer.count();
  return s;
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
  buffer.put_count(t.moving ? 1 : 0);
  buffer.put_count(t.motion_prior ? 1 : 0);
  buffer.put(t.nominal_speed_mps);
  buffer.put_count(t.segments.size());
  for (const Segment& s : t.segments) put_segment(s, buffer);
  for (const std::size_t count : {t.arrivals.size(), t.bearings.size(), t.poses.size(), t.odometry.size(),
                                  t.motion_steps.size(), t.nodes.size()})
    buffer.put_count(count);
  for (const ArrivalObservation& o : t.arrivals) {
    put_arrival(o, rows[o.arrival], buffer);
    if (o.two_way) put_pose(t.T_hear_send[static_cast<std::size_t>(o.hear_send)], buffer);
  }
  for (const BearingObservation& o : t.bearings) put_bearing(o, buffer);
  for (const PoseObservation& o : t.poses) put_measured_pose(o, buffer);
  for (const OdometryObservation& o : t.odometry) put_odometry(o, buffer);
  for (const MotionObservation& o : t.motion_steps) {
    buffer.put_count(o.node);
    buffer.put(o.step_s);
  }
  for (const Node& node : t.nodes) put_node(node, buffer);
}

void read_trajectory(const TrajectoryModel& model, BufferReader& buffer, Trajectory& to,
                     std::vector<Arrival>& rows) {
  to.motion = model.motion;
  to.has_cycle_offset = model.timing.clock == Clock::kCycleOffset;
  to.turnaround_s = model.timing.turnaround_s;
  to.moving = buffer.count() != 0;
  if (buffer.count() != 0) to.motion_prior = model.motion_priors[to.vehicle.index()];
  to.nominal_speed_mps = buffer.get();
  const std::size_t nodes = to.nodes.size();
  for (std::size_t n = buffer.count(); n > 0; --n) {
    Segment s = get_segment(buffer);
    move_behind(to, s);
    to.segments.push_back(s);
  }
  std::size_t counts[6];
  for (std::size_t& count : counts) count = buffer.count();
  for (; counts[0] > 0; --counts[0]) {
    Arrival a;
    ArrivalObservation o = get_arrival(model, to.vehicle, buffer, a);
    o.node += static_cast<std::uint32_t>(nodes);
    o.arrival = static_cast<std::uint32_t>(rows.size());
    if (o.two_way) {
      o.hear_send = static_cast<std::int32_t>(to.T_hear_send.size());
      to.T_hear_send.push_back(get_pose(buffer));
    }
    to.arrivals.push_back(o);
    rows.push_back(a);
  }
  for (; counts[1] > 0; --counts[1]) {
    to.bearings.push_back(get_bearing(buffer));
    to.bearings.back().node += nodes;
  }
  for (; counts[2] > 0; --counts[2]) {
    to.poses.push_back(get_measured_pose(buffer));
    to.poses.back().node += nodes;
  }
  for (; counts[3] > 0; --counts[3]) {
    to.odometry.push_back(get_odometry(buffer));
    to.odometry.back().node += nodes;
  }
  for (; counts[4] > 0; --counts[4]) {
    MotionObservation o;
    o.node = buffer.count() + nodes;
    o.step_s = buffer.get();
    to.motion_steps.push_back(o);
  }
  for (; counts[5] > 0; --counts[5]) to.nodes.push_back(get_node(buffer));
}

}  // namespace octant::calib
