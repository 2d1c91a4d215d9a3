// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// All kinds of trajectories are read back as written.
#include "calib/stream/trajectory_buffer.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/calib/at_truth.h"

namespace octant::test {
namespace trajectory_buffer_test {

RC_GTEST_PROP(Tape, ReadsWhatWasWritten, (std::vector<std::int64_t> integers, std::vector<double> numbers)) {
  std::vector<double> buffer;
  calib::BufferWriter writer(buffer);
  writer.exchange(integers, numbers);
  calib::BufferReader reader(buffer);
  std::vector<std::int64_t> integers_back;
  std::vector<double> numbers_back;
  reader.exchange(integers_back, numbers_back);
  RC_ASSERT(integers_back == integers);
  RC_ASSERT(numbers_back == numbers);
  RC_ASSERT(reader.ended());
}

TEST(Tape, HoldsIntegersThatADoubleDoesNot) {
  std::vector<double> buffer;
  calib::BufferWriter writer(buffer);
  const std::int64_t all[] = {std::numeric_limits<std::int64_t>::min(), -1, 0, (std::int64_t{1} << 53) + 1,
                              std::numeric_limits<std::int64_t>::max()};
  for (const std::int64_t i : all) writer.exchange(i);
  calib::BufferReader reader(buffer);
  for (const std::int64_t i : all) {
    std::int64_t back = 0;
    reader.exchange(back);
    EXPECT_EQ(back, i);
  }
}

TEST(Tape, ReadBeyondItsEndIsABugThatIsSaid) {
  const std::vector<double> buffer = {1.0};
  calib::BufferReader reader(buffer);
  EXPECT_FALSE(reader.ended());
  double number = 0.0;
  reader.exchange(number);
  EXPECT_EQ(number, 1.0);
  EXPECT_TRUE(reader.ended());
  EXPECT_THROW(reader.exchange(number), std::out_of_range);
}

/// Bit for bit, because NaN (an amplitude that was not logged) must remain NaN.
void expect_same(double a, double b) {
  EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << a << ", " << b;
}
void expect_same(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.translation_m, b.translation_m);
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
}

void expect_same_states(const Trajectory& a, const Trajectory& b, std::size_t from) {
  ASSERT_EQ(b.nodes.size(), from + a.nodes.size());
  for (std::size_t k = 0; k < a.nodes.size(); ++k) {
    const Node &x = a.nodes[k], &y = b.nodes[from + k];
    EXPECT_EQ(x.time_s, y.time_s);
    EXPECT_EQ(x.epoch, y.epoch);
    EXPECT_EQ(x.placed, y.placed);
    EXPECT_EQ(x.cycle_offset_s, y.cycle_offset_s);
    EXPECT_EQ(x.velocity, y.velocity);
    expect_same(x.T_map_vehicle, y.T_map_vehicle);
  }
}

void expect_same_arrivals(const Trajectory& a, const std::vector<Arrival>& rows, const Trajectory& b,
                          const std::vector<Arrival>& read, std::size_t nodes, std::size_t from) {
  ASSERT_EQ(b.arrivals.size(), from + a.arrivals.size());
  for (std::size_t i = 0; i < a.arrivals.size(); ++i) {
    const ArrivalObservation &x = a.arrivals[i], &y = b.arrivals[from + i];
    EXPECT_EQ(x.node + nodes, y.node);
    EXPECT_EQ(x.beacon, y.beacon);
    EXPECT_EQ(x.receiver, y.receiver);
    EXPECT_EQ(x.alpha, y.alpha);
    EXPECT_EQ(x.time_s, y.time_s);
    EXPECT_EQ(x.tof_s, y.tof_s);
    EXPECT_EQ(x.sigma_s, y.sigma_s);
    EXPECT_EQ(x.model_speed_mps, y.model_speed_mps);
    EXPECT_EQ(x.log_amplitude, y.log_amplitude);
    EXPECT_EQ(x.log_amplitude_sigma, y.log_amplitude_sigma);
    EXPECT_EQ(x.rejection, y.rejection);
    ASSERT_EQ(x.two_way, y.two_way);
    if (x.two_way)
      expect_same(a.T_hear_send[static_cast<std::size_t>(x.hear_send)],
                  b.T_hear_send[static_cast<std::size_t>(y.hear_send)]);
    const Arrival &was = rows[x.arrival], &is = read.at(y.arrival);
    EXPECT_EQ(was.line, is.line);
    EXPECT_EQ(was.epoch, is.epoch);
    EXPECT_EQ(was.vehicle, is.vehicle);
    expect_same(was.temperature_degC, is.temperature_degC);
    expect_same(was.amplitude_v, is.amplitude_v);
  }
}

void expect_same_segments(const Trajectory& a, const Trajectory& b, std::size_t nodes, std::size_t from) {
  ASSERT_EQ(b.segments.size() % a.segments.size(), 0U);
  const std::size_t first = b.segments.size() - a.segments.size();
  for (std::size_t s = 0; s < a.segments.size(); ++s) {
    const Segment &x = a.segments[s], &y = b.segments[first + s];
    EXPECT_EQ(x.first_node + nodes, y.first_node);
    EXPECT_EQ(x.last_node + nodes, y.last_node);
    EXPECT_EQ(x.first_arrival + from, y.first_arrival);
    EXPECT_EQ(x.last_arrival + from, y.last_arrival);
    EXPECT_EQ(x.last_pose - x.first_pose, y.last_pose - y.first_pose);
    EXPECT_EQ(x.last_odometry - x.first_odometry, y.last_odometry - y.first_odometry);
    EXPECT_EQ(x.last_motion - x.first_motion, y.last_motion - y.first_motion);
  }
}

/// Written, and read twice, one behind the other.
void expect_read_as_written(const AtTruth& at) {
  Trajectory t = at.trajectories[0];
  const std::vector<Arrival>& rows = at.problem.runs[0].arrivals;
  for (std::size_t i = 0; i < t.arrivals.size(); i += 7) t.arrivals[i].rejection = Rejection::kLate;
  t.nodes[1].placed = false;
  std::vector<double> numbers;
  calib::BufferWriter writer(numbers);
  calib::write_trajectory(t, rows, writer);
  calib::write_trajectory(t, rows, writer);
  Trajectory back;
  back.vehicle = t.vehicle;
  std::vector<Arrival> read;
  calib::BufferReader reader(numbers);
  for (std::size_t turn = 0; turn < 2; ++turn) {
    const std::size_t nodes = back.nodes.size(), arrivals = back.arrivals.size();
    calib::read_trajectory(calib::trajectory_model(at.problem.site), reader, back, read);
    expect_same_states(t, back, nodes);
    expect_same_arrivals(t, rows, back, read, nodes, arrivals);
    expect_same_segments(t, back, nodes, arrivals);
  }
  EXPECT_TRUE(reader.ended());
  EXPECT_EQ(back.motion, t.motion);
  EXPECT_EQ(back.moving, t.moving);
  EXPECT_EQ(back.has_cycle_offset, t.has_cycle_offset);
  EXPECT_EQ(back.nominal_speed_mps, t.nominal_speed_mps);
  EXPECT_EQ(back.motion_prior.has_value(), t.motion_prior.has_value());
  EXPECT_EQ(back.turnaround_s, t.turnaround_s);
  ASSERT_EQ(back.poses.size(), 2 * t.poses.size());
  for (std::size_t i = 0; i < t.poses.size(); ++i) {
    const PoseObservation &x = t.poses[i], &y = back.poses[t.poses.size() + i];
    EXPECT_EQ(x.node + t.nodes.size(), y.node);
    EXPECT_EQ(x.alpha, y.alpha);
    EXPECT_EQ(x.position_sigma_m, y.position_sigma_m);
    expect_same(x.heading_sigma_rad, y.heading_sigma_rad);
    EXPECT_EQ(x.attitude_sigma_rad, y.attitude_sigma_rad);
    expect_same(x.T_map_vehicle, y.T_map_vehicle);
  }
  ASSERT_EQ(back.odometry.size(), 2 * t.odometry.size());
  for (std::size_t i = 0; i < t.odometry.size(); ++i) {
    const OdometryObservation &x = t.odometry[i], &y = back.odometry[t.odometry.size() + i];
    EXPECT_EQ(x.node + t.nodes.size(), y.node);
    EXPECT_EQ(x.distance_sigma_m, y.distance_sigma_m);
    EXPECT_EQ(x.heading_sigma_rad, y.heading_sigma_rad);
    expect_same(x.T_before_after, y.T_before_after);
  }
}

TEST(TrajectoryTape, OfStopsWithAmplitudesAndTemperatures) {
  Scenario s = hall_scenario();
  s.path.epochs = 8;
  add_attenuation(s);
  s.log_amplitude = true;
  s.warming_degC = 3.0;
  s.log_poses = true;
  expect_read_as_written(AtTruth(s, 1));
}

TEST(TrajectoryTape, OfCyclesWithOffsets) {
  Scenario s = hall_scenario();
  s.path.epochs = 8;
  s.site.timing.clock = Clock::kCycleOffset;
  AtTruth at(s, 1);
  for (Node& node : at.trajectories[0].nodes) node.cycle_offset_s = 1e-3 * node.time_s;
  expect_read_as_written(at);
}

TEST(TrajectoryTape, OfTwoWayRanging) {
  Scenario s = drive_scenario(10.0);
  s.site.timing.ranging = Ranging::kTwoWay;
  s.site.timing.turnaround_s = 0.01;
  const AtTruth at(s, 1);
  ASSERT_TRUE(at.trajectories[0].arrivals[0].two_way);
  expect_read_as_written(at);
}

TEST(TrajectoryTape, OfADriveInSpace) {
  Scenario s = drive_scenario(10.0);
  s.site.motion = Motion::kSpatial;
  s.log_odometry = s.log_poses = true;
  expect_read_as_written(AtTruth(s, 1));
}

}  // namespace trajectory_buffer_test
}  // namespace octant::test
