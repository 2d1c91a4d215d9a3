// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Stops, drives and all else of one calibration.
#include "calib/streamed.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/stream/long_log.h"
#include "tests/calib/stream/same_drive.h"
#include "tests/calib/thread_team.h"

namespace octant::test {
namespace streamed_kinds_test {

/// The run is a drive, the validation run has stops.
World drive_and_stops(int seed, double duration_s, int epochs) {
  Scenario s = drive_scenario(duration_s);
  s.heldout_path.kind = PathKind::kStops;
  s.heldout_path.epochs = epochs;
  s.echo_fraction = 0.02;
  return must(simulate(s, static_cast<std::uint64_t>(seed)));
}

TEST(StreamedLog, StopsAndDrivesSayWhatTheWholeSays) {
  const World world = drive_and_stops(1, 500.0, 1500);
  ASSERT_TRUE(world.heldout.has_epochs);
  EXPECT_TRUE(calib::is_long(must(calib::make_problem(world.site, {world.run, world.heldout}))));
  expect_same_drive(world.site, {world.run, world.heldout});
  expect_same_drive(world.site, {world.heldout, world.run});
}

// A short drive and many stops, with noise that only the chi-square test detects.
TEST(StreamedLog, FindsTheNoiseOfStopsAndDrives) {
  const World world = drive_and_stops(2, 150.0, 4200);
  Site site = world.site;
  site.noise.tof_sigma_s *= 1.1;
  expect_same_drive(site, {world.run, world.heldout});
}

TEST(StreamedLog, RanksShareStopsAndDrives) {
  const World world = drive_and_stops(3, 400.0, 1500);
  const std::vector<MeasurementLog> runs = {world.run, world.heldout};
  const calib::Solution alone = streamed_drive(world.site, runs).solution;
  ASSERT_EQ(alone.status, calib::SolveStatus::kConverged) << alone.message;
  std::vector<calib::Solution> answers(2);
  for_each_rank(2, [&](const calib::Ranks& rank) {
    calib::SolveOptions options;
    options.ranks = &rank;
    answers[static_cast<std::size_t>(rank.index())] = streamed_drive(world.site, runs, options).solution;
  });
  for (const calib::Solution& answer : answers) {
    for (std::size_t b = 0; b < alone.state.beacon_p_map_m.size(); ++b)
      EXPECT_LT((alone.state.beacon_p_map_m[b] - answer.state.beacon_p_map_m[b]).norm(), 1e-8);
    EXPECT_EQ(answer.statistics.rejected, alone.statistics.rejected);
    EXPECT_EQ(answer.statistics.unknowns, alone.statistics.unknowns);
  }
}

// Each time separately, at its measured pose; some arrivals are in a gap of the poses.
TEST(StreamedLog, MomentsAtMeasuredPosesMayBeStreamed) {
  Scenario s = drive_scenario(300.0);
  s.heldout_path.duration_s = 5.0;
  s.log_poses = true;
  s.pose_accuracy = {.position_sigma_m = 0.001, .heading_sigma_rad = 0.001};
  s.echo_fraction = 0.02;
  World world = must(simulate(s, 21));
  world.run.odometry.clear();
  std::erase_if(world.run.poses, [](const TimedPose& p) { return p.time_s > 100.0 && p.time_s < 110.0; });
  const calib::Problem problem = must(calib::make_problem(world.site, {world.run}));
  ASSERT_FALSE(problem.trajectories.front().stateless_arrivals.empty());
  ASSERT_GT(problem.trajectories.front().segments.size(), 1000U);
  expect_same_drive(world.site, {world.run});
}

// Their component of variance is found in chunks as in memory.
TEST(StreamedLog, PosesMayBeBetterThanStated) {
  Scenario s = drive_scenario(300.0);
  s.heldout_path.duration_s = 5.0;
  s.log_poses = true;
  s.pose_accuracy = {.position_sigma_m = 0.0, .heading_sigma_rad = 0.0};
  World world = must(simulate(s, 21));
  world.run.odometry.clear();
  world.run.pose_accuracy = {.position_sigma_m = 0.01, .heading_sigma_rad = 0.01};
  const calib::Solution whole = calib::solve(must(calib::make_problem(world.site, {world.run})), {});
  ASSERT_THAT(whole.warnings, ::testing::Contains(::testing::HasSubstr("measured poses fit")));
  expect_same_drive(world.site, {world.run});
}

// One receiver, no headings: its position is fixed, and measured positions have its sigma in addition.
TEST(StreamedLog, AReceiverThatIsHeldMayBeStreamed) {
  Scenario s = hall_scenario();
  s.site.vehicles.clear();
  s.site.receivers.clear();
  add_receivers(s.site, {{0.0, 0.0, 0.3}}, 0.008);
  s.path.epochs = 600;
  s.heldout_path.epochs = 1;
  s.log_poses = true;
  s.pose_accuracy = {.position_sigma_m = 0.003, .heading_known = false};
  const World world = must(simulate(s, 26));
  const calib::Problem problem = must(calib::make_problem(world.site, {world.run}));
  ASSERT_EQ(problem.held_lever_sigma_m, std::vector<double>{0.008});
  ASSERT_NEAR(problem.trajectories.front().poses.front().position_sigma_m, std::hypot(0.003, 0.008), 1e-12);
  expect_same_drive(world.site, {world.run});
}

// Only arrivals: data between pauses are connected by the prior, and are complete in one chunk.
TEST(StreamedLog, DrivesWithAMotionPriorMayBeStreamed) {
  Scenario s = drive_scenario(300.0);
  s.heldout_path.duration_s = 5.0;
  s.site.vehicles[0].motion = MotionPrior{0.8, 0.8, 0.8, 1.5};
  World world = must(simulate(s, 22));
  world.run.odometry.clear();
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return std::fmod(a.time_s, 75.0) > 60.0; });
  const calib::Problem problem = must(calib::make_problem(world.site, {world.run}));
  ASSERT_TRUE(problem.trajectories.front().motion_prior);
  ASSERT_GT(problem.trajectories.front().segments.size(), 3U);
  expect_same_drive(world.site, {world.run});
}

/// Odometry from stop to stop along the truth, with its noise.
void add_odometry_between_stops(MeasurementLog& run, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  const OdometryAccuracy& accuracy = run.odometry_accuracy;
  Pose before;
  for (std::size_t i = 0; i < run.truth.size(); ++i) {
    const bool begins = i == 0 || run.truth[i].time_s - run.truth[i - 1].time_s > 0.5,
               ends = i + 1 == run.truth.size() || run.truth[i + 1].time_s - run.truth[i].time_s > 0.5;
    if (!begins && !ends) continue;
    OdometryStep step{.time_s = run.truth[i].time_s, .vehicle = VehicleId(0)};
    if (!run.odometry.empty()) {
      const Pose T = before.inverse() * run.truth[i].T_map_vehicle;
      const double d_m = T.translation_m.norm();
      const double place_m =
                       std::hypot(accuracy.distance_sigma_m_per_sqrt_m * std::sqrt(d_m), accuracy.floor_m),
                   turn_rad =
                       std::hypot(accuracy.heading_sigma_rad_per_sqrt_m * std::sqrt(d_m), accuracy.floor_rad);
      step.dx_m = T.translation_m.x() + place_m * noise(random);
      step.dy_m = T.translation_m.y() + place_m * noise(random);
      step.dheading_rad = T.heading_rad() + turn_rad * noise(random);
    }
    before = run.truth[i].T_map_vehicle;
    run.odometry.push_back(step);
  }
}

TEST(StreamedLog, StopsTiedByOdometryMayBeStreamed) {
  Scenario s = hall_scenario();
  s.path.epochs = 500;
  s.heldout_path.epochs = 1;
  s.echo_fraction = 0.02;
  World world = must(simulate(s, 23));
  add_odometry_between_stops(world.run, 23);
  const calib::Problem problem = must(calib::make_problem(world.site, {world.run}));
  ASSERT_EQ(problem.trajectories.front().segments.size(), 1U);
  ASSERT_EQ(problem.trajectories.front().odometry.size(), 499U);
  expect_same_drive(world.site, {world.run});
}

// One vehicle of the run has odometry, the other has not: a piece of the first and a chunk of the second.
TEST(StreamedLog, AVehicleWithoutOdometryMayBeBesideADrive) {
  World world = must(simulate(drive_scenario(240.0), 24));
  const std::size_t receivers = world.site.receivers.size();
  add_octagon(world.site, 0.3, 0.001, "other");
  std::erase_if(world.run.odometry, [](const OdometryStep& o) { return o.time_s > 150.0; });
  for (Arrival& a : world.run.arrivals) {
    if (a.time_s <= 150.0) continue;
    a.vehicle = VehicleId(1);
    a.receiver = ReceiverId(a.receiver.index() + receivers);
  }
  world.site.vehicles[1].motion = MotionPrior{0.8, 0.8, 0.8, 1.5};
  const calib::Problem problem = must(calib::make_problem(world.site, {world.run}));
  ASSERT_EQ(problem.trajectories.size(), 2U);
  ASSERT_TRUE(problem.trajectories[1].motion_prior);
  expect_same_drive(world.site, {world.run});
}

// Stops, a drive, times at measured poses and stops linked by odometry: their results add up.
TEST(StreamedLog, AllKindsOfRunsMayBeTogether) {
  Scenario s = drive_scenario(120.0);
  s.heldout_path = hall_scenario().path;
  s.log_poses = true;
  s.pose_accuracy = {.position_sigma_m = 0.02, .heading_sigma_rad = 0.02};
  const World world = must(simulate(s, 25));
  MeasurementLog drive = world.run, moments = world.run, stops = world.heldout, chained = world.heldout;
  drive.poses.clear();
  moments.odometry.clear();
  moments.path = "moments";
  stops.poses.clear();
  chained.poses.clear();
  chained.path = "chained";
  std::erase_if(drive.arrivals, [](const Arrival& a) { return a.line % 2 == 0; });
  std::erase_if(moments.arrivals, [](const Arrival& a) { return a.line % 2 == 1; });
  std::erase_if(stops.arrivals, [](const Arrival& a) { return a.epoch % 2 == 0; });
  std::erase_if(chained.arrivals, [](const Arrival& a) { return a.epoch % 2 == 1; });
  add_odometry_between_stops(chained, 25);
  expect_same_drive(world.site, {drive, stops, moments, chained});
}

}  // namespace streamed_kinds_test
}  // namespace octant::test
