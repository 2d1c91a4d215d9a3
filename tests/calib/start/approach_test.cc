// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/approach.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/start/progress_monitor.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace approach_test {

using ::testing::HasSubstr;

calib::Approach approach_of(const World& world, const calib::SolveOptions& options = {},
                            bool search_again = true) {
  calib::ProgressMonitor monitor(options);
  return calib::approach(problem_of(world), options, monitor, search_again);
}

/// Largest distance of a beacon from the truth.
double worst_of(const World& world, const calib::Approach& a) {
  const SharedState state = a.estimate.state();
  double worst_m = 0.0;
  for (std::size_t b = 0; b < world.truth.beacons.size(); ++b)
    worst_m = std::max(worst_m, (state.beacon_p_map_m[b] - world.truth.beacons[b].position_m).norm());
  return worst_m;
}

/// Root mean square of the stops' distances from where they were.
double stops_off_m(const World& world, const calib::Approach& a) {
  double squares = 0.0, count = 0.0;
  for (const Trajectory& t : a.trajectories)
    for (const Node& node : t.nodes) {
      Pose truth;
      EXPECT_TRUE(node.placed);
      if (!interpolate_poses(world.run.truth, node.time_s, 10.0, truth)) continue;
      squares += (node.T_map_vehicle.translation_m - truth.translation_m).squaredNorm();
      ++count;
    }
  EXPECT_GT(count, 50.0);
  return std::sqrt(squares / count);
}

// Beacons with errors of decimetres, one arrival in ten an echo: after the robust initialisation errors are
// centimetres.
TEST(Approach, ComesFromDecimetresToCentimetresThroughEchoes) {
  for (const double echoes : {0.0, 0.1}) {
    Scenario s = hall_scenario();
    s.echo_fraction = echoes;
    const World world = must(simulate(s, 3));
    const calib::Approach a = approach_of(world);
    ASSERT_TRUE(a.ok);
    double stated_m = 0.0;
    for (std::size_t b = 0; b < world.truth.beacons.size(); ++b) {
      EXPECT_TRUE(a.estimate.beacon_usable[b]);
      const SharedState prior = prior_state(world.site);
      stated_m = std::max(stated_m, (prior.beacon_p_map_m[b] - world.truth.beacons[b].position_m).norm());
    }
    EXPECT_GT(stated_m, 0.3);
    EXPECT_LT(worst_of(world, a), 0.03) << echoes;
    EXPECT_LT(stops_off_m(world, a), 0.02) << echoes;
    EXPECT_NEAR(a.estimate.noise_factor, 1.0, 0.5) << echoes;
    EXPECT_TRUE(a.warnings.empty());
  }
}

// Two free beacons whose signs were exchanged: found, corrected, and reported by name.
TEST(Approach, ExchangedBeaconsAreMendedAndNamed) {
  Scenario s = hall_scenario();
  World world = must(simulate(s, 4));
  const calib::Approach before = approach_of(world);
  std::swap(world.site.beacons[1].position_m, world.site.beacons[4].position_m);
  const calib::Approach a = approach_of(world);
  ASSERT_TRUE(before.ok && a.ok);
  EXPECT_LT(worst_of(world, a), 0.03);
  EXPECT_NEAR((a.estimate.state().beacon_p_map_m[1] - before.estimate.state().beacon_p_map_m[1]).norm(), 0.0,
              0.005);
  ASSERT_FALSE(a.warnings.empty());
  EXPECT_THAT(a.warnings.front(), HasSubstr("B1"));
  EXPECT_THAT(a.warnings.front(), HasSubstr("B4"));
}

// One receiver, and neither beacons nor vehicle are known: no bearings of an array, no position.
TEST(Approach, SaysWhyThereIsNone) {
  Scenario s = hall_scenario();
  s.site.receivers.clear();
  s.site.vehicles.clear();
  add_receivers(s.site, {{0.0, 0.0, 0.3}});
  World world = must(simulate(s, 5));
  for (SiteBeacon& b : world.site.beacons) {
    b.position_m = {};
    b.sigma_m = {};
  }
  const calib::Approach a = approach_of(world);
  EXPECT_FALSE(a.ok);
  EXPECT_EQ(a.why_not.status, calib::SolveStatus::kUndetermined);
  EXPECT_THAT(a.why_not.message, HasSubstr("nothing is exported"));
  ASSERT_FALSE(a.why_not.weak.empty());
  EXPECT_TRUE(a.why_not.weak.front().blocking);
}

TEST(Approach, StopsWhenItIsAskedTo) {
  const World world = must(simulate(hall_scenario(), 6));
  calib::SolveOptions options;
  int calls = 0;
  options.on_progress = [&](const calib::Progress&) { return ++calls < 4; };
  const calib::Approach a = approach_of(world, options);
  EXPECT_FALSE(a.ok);
  EXPECT_EQ(a.why_not.status, calib::SolveStatus::kInterrupted);
  EXPECT_EQ(calls, 4);
}

// If all arrivals agree, the last search changes no state.
TEST(Approach, WithoutItsLastSearchItIsAsGoodWhereArrivalsAgree) {
  const World world = must(simulate(hall_scenario(), 7));
  const calib::Approach whole = approach_of(world), quick = approach_of(world, {}, false);
  ASSERT_TRUE(whole.ok && quick.ok);
  EXPECT_LT(worst_of(world, quick), 0.03);
  EXPECT_LT((whole.estimate.state().beacon_p_map_m[2] - quick.estimate.state().beacon_p_map_m[2]).norm(),
            0.005);
}

// Its attitude is not determined, and no epoch of it had a pose.
TEST(Approach, AStopInSpaceOfOneReceiverHasAPosition) {
  Scenario s = hall_scenario();
  s.site.motion = Motion::kSpatial;
  s.range_m = 25.0;
  s.path.epochs = 40;
  keep_one_receiver(s.site, {0.2, 0.0, 0.3});
  for (std::size_t b = 0; b < s.site.beacons.size(); ++b) {
    s.site.beacons[b].sigma_m = {0.0, 0.0, 0.0};
    if (b % 2 == 0) s.site.beacons[b].position_m[2] = 5.0;  // heights differ, so that no image is as good
  }
  const World world = must(simulate(s, 3));
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  for (const Trajectory& t : solution.trajectories)
    for (const Node& node : t.nodes) {
      ASSERT_TRUE(node.placed);
      Pose truth;
      ASSERT_TRUE(interpolate_poses(world.run.truth, node.time_s, 10.0, truth));
      const Eigen::Vector3d& p_m = world.site.receivers[0].position_m;
      EXPECT_LT((node.T_map_vehicle * p_m - truth * p_m).norm(), 0.1);
    }
}

}  // namespace approach_test
}  // namespace octant::test
