// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Drives that are read again for each step, against the same at once.
#include "calib/stream/drive_passes.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calib/stream/long_log.h"
#include "calib/stream/streamed.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/memory_source.h"

namespace octant::test {
namespace {

constexpr std::size_t kFewStates = 8U << 20U;  // some hundreds of states at a time

calib::StreamedCalibration streamed_drive(const Site& site, const std::vector<MeasurementLog>& runs,
                                          const calib::SolveOptions& options = {},
                                          std::size_t memory = kFewStates, std::size_t block = 300) {
  MemorySource source(runs, block);
  return must(calib::solve_streamed(site, source, options, memory));
}

World long_drive(int seed, double echoes = 0.02, double duration_s = 500.0) {
  Scenario s = drive_scenario(duration_s);
  s.heldout_path.duration_s = 5.0;
  s.echo_fraction = echoes;
  return must(simulate(s, static_cast<std::uint64_t>(seed)));
}

/// Largest difference of the parameters, in sigmas of the whole's.
double largest_in_sigmas(const calib::Problem& problem, const calib::Solution& whole,
                         const calib::Solution& part) {
  const calib::ParameterLayout layout =
      calib::make_layout(problem, whole.state, std::vector<bool>(whole.state.beacon_p_map_m.size(), false));
  Eigen::VectorXd si(layout.size());
  for (int i = 0; i < layout.size(); ++i) si[i] = layout.parameters[static_cast<std::size_t>(i)].si_per_unit;
  const Eigen::VectorXd sigma = whole.covariance.matrix.diagonal().cwiseSqrt();
  const Eigen::VectorXd shift =
      si.cwiseProduct(layout.vector_of(part.state) - layout.vector_of(whole.state)).cwiseQuotient(sigma);
  return shift.cwiseAbs().maxCoeff();
}

/// How far an area reaches in a direction.
double reach_m(const std::vector<Eigen::Vector2d>& area_m, double direction_rad) {
  double reach = -INFINITY;
  for (const Eigen::Vector2d& p : area_m)
    reach = std::max(reach, p.x() * std::cos(direction_rad) + p.y() * std::sin(direction_rad));
  return reach;
}

/// All that is said of drives, streamed or not.
void expect_same_drive(const Site& site, const std::vector<MeasurementLog>& runs) {
  const calib::Problem problem = must(calib::make_problem(site, runs));
  ASSERT_TRUE(calib::is_long_drive(problem));
  const calib::Solution whole = calib::solve(problem, {});
  const calib::StreamedCalibration s = streamed_drive(site, runs);
  const calib::Solution& part = s.solution;
  ASSERT_EQ(part.status, whole.status) << part.message;
  ASSERT_EQ(part.covariance.parameters, whole.covariance.parameters);
  EXPECT_LT(largest_in_sigmas(problem, whole, part), 1e-3);
  const double scale = whole.covariance.matrix.cwiseAbs().maxCoeff();
  EXPECT_LT((part.covariance.matrix - whole.covariance.matrix).cwiseAbs().maxCoeff(), 1e-4 * scale);
  EXPECT_EQ(part.statistics.arrivals, whole.statistics.arrivals);
  EXPECT_EQ(part.statistics.rejected, whole.statistics.rejected);
  EXPECT_EQ(part.statistics.unknowns, whole.statistics.unknowns);
  EXPECT_EQ(part.statistics.redundancy, whole.statistics.redundancy);
  EXPECT_NEAR(part.statistics.variance_factor, whole.statistics.variance_factor,
              1e-6 * whole.statistics.variance_factor);
  EXPECT_NEAR(part.statistics.rms_s, whole.statistics.rms_s, 1e-5 * whole.statistics.rms_s);
  EXPECT_NEAR(part.tof_sigma_s, whole.tof_sigma_s, 1e-6 * whole.tof_sigma_s);
  EXPECT_EQ(part.warnings, whole.warnings);
  EXPECT_EQ(part.beacon_status, whole.beacon_status);
  EXPECT_EQ(part.contradictions.size(), whole.contradictions.size());
  EXPECT_NEAR(s.problem.typical_range_m, problem.typical_range_m, 1e-9);
  std::size_t states = 0;
  for (const Trajectory& t : whole.trajectories) states += t.nodes.size();
  ASSERT_TRUE(part.whole);
  EXPECT_EQ(part.whole->epochs, states);
  std::vector<std::size_t> left_out(calib::kRejections, 0), counted(calib::kRejections, 0);
  for (const calib::LeftOut& l : whole.left_out) ++left_out[static_cast<std::size_t>(l.reason)];
  for (const auto& of_beacon : part.whole->of_beacon)
    for (std::size_t r = 1; r < calib::kRejections; ++r) counted[r] += of_beacon[r];
  EXPECT_EQ(counted, left_out);
  ASSERT_TRUE(part.reliability.ok);
  EXPECT_NEAR(part.reliability.mean_redundancy, whole.reliability.mean_redundancy, 0.02);
  EXPECT_NEAR(part.reliability.redundancy_sum, whole.reliability.redundancy_sum,
              0.03 * whole.reliability.redundancy_sum);
  for (std::size_t b = 0; b < part.reliability.beacons.size(); ++b) {
    EXPECT_EQ(part.reliability.beacons[b].used, whole.reliability.beacons[b].used);
    EXPECT_EQ(part.reliability.beacons[b].late, whole.reliability.beacons[b].late);
  }
  const Deployment a = calib::make_deployment(problem, whole, {}),
                   b = calib::make_deployment(s.problem, part, {});
  for (int i = 0; i < 16; ++i)
    EXPECT_NEAR(reach_m(a.validity_area_m, 0.4 * i), reach_m(b.validity_area_m, 0.4 * i), 1e-4);
  EXPECT_EQ(a.validity_temperature_degC, b.validity_temperature_degC);
}

TEST(DrivePasses, SayWhatTheWholeSays) {
  const World world = long_drive(1);
  expect_same_drive(world.site, {world.run});
}

// Off by what only the chi-square test sees.
TEST(DrivePasses, FindTheNoiseOfTheWhole) {
  const World world = long_drive(2, 0.01);
  Site site = world.site;
  site.noise.tof_sigma_s *= 1.1;
  expect_same_drive(site, {world.run});
}

// Grossly off: the filters that place the states then take a third of the arrivals for outliers. Arrivals
// between 3.6 and 4 sigmas stay what they first were, and of a few that depends on where a filter began.
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

// Half a minute in which nothing is heard, and arrivals before the first odometry row.
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

TEST(DrivePasses, AFileThatChangesIsAnError) {
  const World world = long_drive(8);
  MemorySource source(std::vector<MeasurementLog>{world.run}, 300);
  calib::SolveOptions options;
  options.on_progress = [&](const calib::Progress& p) {
    source.forgets = p.stage == "states of the whole log";
    return true;
  };
  const auto answer = calib::solve_streamed(world.site, source, options, kFewStates);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message().find("changed"), std::string::npos) << answer.error().message();
}

TEST(DrivePasses, WhatCannotBe) {
  const World world = long_drive(9, 0.0, 20.0);
  EXPECT_FALSE(calib::why_not_streamed(world.site, {&world.run}));
  MeasurementLog run = world.run;
  run.has_epochs = true;
  EXPECT_TRUE(calib::why_not_streamed(world.site, {&run})) << "stops with odometry";
  EXPECT_TRUE(calib::why_not_streamed(world.site, {&world.run, &run}));
  run = world.run;
  run.poses.resize(1);
  EXPECT_TRUE(calib::why_not_streamed(world.site, {&run}));
  Site site = world.site;
  site.vehicles.push_back({.name = "other"});
  EXPECT_TRUE(calib::why_not_streamed(site, {&world.run})) << "a vehicle without odometry";
  site = world.site;
  site.gates.max_range_m = 10.0;
  EXPECT_TRUE(calib::why_not_streamed(site, {&world.run}));
}

}  // namespace
}  // namespace octant::test
