// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Drives that are read again for each step, against the same at once.
#include "calib/stream/drives/drive_passes.h"

#include <thread>

#include <gtest/gtest.h>

#include "calib/stream/long_log.h"
#include "tests/calib/stream/changed_log.h"
#include "tests/calib/stream/same_drive.h"
#include "tests/calib/stream/share_of_ranks.h"

namespace octant::test {
namespace drive_passes_test {

World long_drive(int seed, double echoes = 0.02, double duration_s = 500.0) {
  Scenario s = drive_scenario(duration_s);
  s.heldout_path.duration_s = 5.0;
  s.echo_fraction = echoes;
  return must(simulate(s, static_cast<std::uint64_t>(seed)));
}

TEST(DrivePasses, SayWhatTheWholeSays) {
  const World world = long_drive(1);
  expect_same_drive(world.site, {world.run});
}

// An error that only the chi-square test detects.
TEST(DrivePasses, FindTheNoiseOfTheWhole) {
  const World world = long_drive(2, 0.01);
  Site site = world.site;
  site.noise.tof_sigma_s *= 1.1;
  expect_same_drive(site, {world.run});
}

// A large error: the filters that solve the states then reject a third of the arrivals. Arrivals between 3.6
// and 4 sigmas keep their first mark, which for a few depends on the start of a filter.
TEST(DrivePasses, FindNoiseThatIsGrosslyOff) {
  const World world = long_drive(2, 0.01);
  Site site = world.site;
  site.noise.tof_sigma_s *= 0.3;
  const calib::Problem problem = must(calib::make_problem(site, {world.run}));
  const calib::Solution whole = calib::solve(problem, {}), part = streamed_drive(site, {world.run}).solution;
  ASSERT_EQ(part.status, calib::SolveStatus::kConverged) << part.message;
  EXPECT_LT(largest_in_sigmas(problem, whole, part), 0.3);
  EXPECT_NEAR(part.tof_sigma_s, whole.tof_sigma_s, 1e-3 * whole.tof_sigma_s);
}

TEST(DrivePasses, RunsKeepTheirSpeeds) {
  const World world = long_drive(3, 0.01, 520.0);
  Site site = world.site;
  site.speed_offset_per_run = true;
  MeasurementLog first = world.run, second = world.run;
  second.path = "second";
  const auto is_late = [](const auto& row) { return row.time_s >= 270.0; };
  std::erase_if(first.arrivals, is_late);
  std::erase_if(first.odometry, is_late);
  std::erase_if(second.arrivals, [&](const Arrival& a) { return !is_late(a); });
  std::erase_if(second.odometry, [&](const OdometryStep& s) { return !is_late(s); });
  for (Arrival& a : second.arrivals)
    a.tof_s += 5e-4 * (a.tof_s - world.truth.beacons[a.beacon.index()].delay_s);
  expect_same_drive(site, {first, second});
}

// Half a minute without arrivals, and arrivals before the first odometry row.
TEST(DrivePasses, ReachByOdometryWhatNothingPlaces) {
  World world = long_drive(5, 0.02, 540.0);
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return a.time_s > 200.0 && a.time_s < 235.0; });
  world.run.odometry.erase(world.run.odometry.begin(), world.run.odometry.begin() + 15);
  expect_same_drive(world.site, {world.run});
}

TEST(DrivePasses, DependNeitherOnThreadsNorOnBlocks) {
  const World world = long_drive(6);
  calib::SolveOptions options;
  const calib::Solution one = streamed_drive(world.site, {world.run}, options).solution;
  options.threads = 3;
  const calib::Solution three = streamed_drive(world.site, {world.run}, options).solution;
  ASSERT_EQ(one.status, calib::SolveStatus::kConverged) << one.message;
  for (std::size_t b = 0; b < one.state.beacon_p_map_m.size(); ++b)
    EXPECT_EQ(one.state.beacon_p_map_m[b], three.state.beacon_p_map_m[b]);
  EXPECT_EQ(one.statistics.variance_factor, three.statistics.variance_factor);
  const calib::Solution blocks = streamed_drive(world.site, {world.run}, {}, 20 * kFewStates, 4097).solution;
  for (std::size_t b = 0; b < one.state.beacon_p_map_m.size(); ++b)
    EXPECT_LT((one.state.beacon_p_map_m[b] - blocks.state.beacon_p_map_m[b]).norm(), 1e-7);
  EXPECT_EQ(one.statistics.rejected, blocks.statistics.rejected);
}

TEST(DrivePasses, StopWhereTheyAreAskedTo) {
  const World world = long_drive(7);
  for (const char* stage : {"states of the whole log", "adjustment of the arrivals that agree"}) {
    calib::SolveOptions options;
    int calls = 0;
    options.on_progress = [&](const calib::Progress& p) { return p.stage != stage || ++calls < 3; };
    EXPECT_EQ(streamed_drive(world.site, {world.run}, options).solution.status,
              calib::SolveStatus::kInterrupted)
        << stage;
  }
}

TEST(DrivePasses, AFileThatChangesIsAnError) { expect_a_changed_log_to_be_an_error(long_drive(8)); }

TEST(DrivePasses, KeepRangeGates) {
  const World world = long_drive(10, 0.05);
  Site site = world.site;
  site.gates.min_range_m = 1.5;
  site.gates.max_range_m = 10.5;
  expect_same_drive(site, {world.run});
}

TEST(DrivePasses, KeepMeasuredPoses) {
  Scenario s = drive_scenario(500.0);
  s.heldout_path.duration_s = 5.0;
  s.log_poses = true;
  s.pose_accuracy = {.position_sigma_m = 0.02, .heading_sigma_rad = 0.02};
  World world = must(simulate(s, 11));
  // As a tracking system has them: for some minutes, now and then.
  std::erase_if(world.run.poses, [](const TimedPose& p) { return std::fmod(p.time_s, 200.0) > 60.0; });
  ASSERT_GT(world.run.poses.size(), 1000U);
  expect_same_drive(world.site, {world.run});
}

/// A vehicle that rotates about all axes, with odometry of all six degrees of freedom.
World long_flight(int seed, double duration_s, double echoes = 0.02) {
  Scenario s = drive_scenario(duration_s);
  s.site.motion = Motion::kSpatial;
  s.log_odometry = true;
  s.heldout_path.duration_s = 5.0;
  s.echo_fraction = echoes;
  return must(simulate(s, static_cast<std::uint64_t>(seed)));
}

TEST(DrivePasses, MayBeInSpace) {
  const World world = long_flight(13, 500.0);
  EXPECT_TRUE(calib::is_long(must(calib::make_problem(world.site, {world.run}))));
  expect_same_drive(world.site, {world.run});
}

// Replies at the start of a piece were requested before it, half a metre away.
TEST(DrivePasses, RangesMayBeTwoWay) {
  Scenario s = drive_scenario(500.0);
  s.site.timing.ranging = Ranging::kTwoWay;
  s.site.timing.turnaround_s = 0.25;
  s.heldout_path.duration_s = 5.0;
  const World world = must(simulate(s, 15));
  expect_same_drive(world.site, {world.run});
}

// Some bearings without a name, some that no state carries, some that point elsewhere.
TEST(DrivePasses, MayHaveBearings) {
  Scenario s = drive_scenario(500.0);
  s.site.noise.bearing_sigma_rad = 0.02;
  s.bearings = Scenario::Bearings{.unlabelled_fraction = 0.1};
  s.heldout_path.duration_s = 5.0;
  World world = must(simulate(s, 16));
  ASSERT_GT(world.run.bearings.size(), 1000U);
  for (std::size_t i = 0; i < world.run.bearings.size(); i += 50) world.run.bearings[i].bearing_rad += 0.5;
  world.run.odometry.erase(world.run.odometry.begin(), world.run.odometry.begin() + 15);
  expect_same_drive(world.site, {world.run});
}

TEST(DrivePasses, RanksReadTheirPiecesAndAgree) {
  World world = long_drive(12, 0.02, 540.0);
  // A segment that only a neighbour's odometry reaches, which may belong to another rank.
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return a.time_s > 200.0 && a.time_s < 235.0; });
  const calib::Problem problem = must(calib::make_problem(world.site, {world.run}));
  const auto in_sigmas = [&](const calib::Solution& a, const calib::Solution& b) {
    return largest_in_sigmas(problem, a, b);
  };
  expect_ranks_to_share_and_agree(world, kFewStates, {2, 3}, in_sigmas, 1e-6);
}

}  // namespace drive_passes_test
}  // namespace octant::test
