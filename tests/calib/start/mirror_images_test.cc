// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/mirror_images.h"

#include <algorithm>
#include <map>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/start/approach.h"
#include "models/trajectory/linearise.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace mirror_images_test {

using calib::SolveStatus;
using testing::Contains;
using testing::HasSubstr;

/// One receiver on the origin stops along a straight line through the hall; of the free beacons only the
/// heights are known.
Scenario straight_line(bool bearings) {
  Scenario s = hall_scenario();
  keep_one_receiver(s.site, {0.0, 0.0, 0.4});
  s.site.noise.bearing_sigma_rad = 0.01;
  for (SiteBeacon& b : s.site.beacons)
    if (!b.is_control_point()) b.sigma_m = {std::nullopt, std::nullopt, 0.01};
  s.range_m = 40.0;
  s.hearing_half_angle_rad = 3.2;
  s.path.kind = PathKind::kWaypoints;
  s.path.waypoints_m = {{1.0, 5.5}, {19.0, 6.5}};
  s.path.epochs = 30;
  if (bearings) s.bearings = Scenario::Bearings{};
  return s;
}

TEST(MirrorImages, BearingsTellTheSidesOfALine) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const World world = must(simulate(straight_line(true), seed));
    const calib::Solution solution = solution_of(world);
    EXPECT_EQ(solution.status, SolveStatus::kConverged) << "seed " << seed << ": " << solution.message;
    EXPECT_LT(worst_beacon_m(world, solution), 0.2) << "seed " << seed;
    EXPECT_TRUE(solution.left_out_bearings.size() < 3) << "seed " << seed;
  }
}

// Ranges too loose to hold an image against bearings, as of a camera: from there the beacon comes back.
TEST(MirrorImages, AnImageThatBearingsLeadBackIsNoSecondPlace) {
  Scenario s = straight_line(true);
  s.site.noise.tof_sigma_s = 1e-3;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const World world = must(simulate(s, seed));
    const calib::Solution solution = solution_of(world);
    EXPECT_THAT(solution.beacon_mirrored, testing::Not(Contains(true)))
        << "seed " << seed << ": " << solution.message;
    EXPECT_LT(worst_beacon_m(world, solution), 1.0) << "seed " << seed;
  }
}

TEST(MirrorImages, WithoutBearingsNoSideIsGuessed) {
  const World world = must(simulate(straight_line(false), 1));
  const calib::Solution solution = solution_of(world);
  EXPECT_EQ(solution.status, SolveStatus::kUndetermined);
  EXPECT_EQ(std::count(solution.beacon_mirrored.begin(), solution.beacon_mirrored.end(), true), 5);
  EXPECT_THAT(solution.message, HasSubstr("mirror image"));
}

TEST(MirrorImages, AnApproximatePlaceTellsTheSide) {
  Scenario s = straight_line(false);
  for (SiteBeacon& b : s.site.beacons)
    if (!b.is_control_point()) b.sigma_m = {0.5, 0.5, 0.01};
  const World world = must(simulate(s, 2));
  const calib::Solution solution = solution_of(world);
  EXPECT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 0.2);
}

/// Stops all over the hall, with two control points on one wall.
Scenario two_control_points(bool bearings) {
  Scenario s = straight_line(bearings);
  s.path.kind = PathKind::kStops;
  s.path.epochs = 60;
  for (std::size_t b = 0; b < s.site.beacons.size(); ++b) {
    if (b < 2) s.site.beacons[b].sigma_m.fill(0.0);
    if (b >= 2) s.site.beacons[b].sigma_m = {std::nullopt, std::nullopt, 0.01};
  }
  return s;
}

/// A hall whose receivers are all at 0.4 m; of one beacon, truly at the height z_m, the height is stated to
/// 0.3 m.
calib::Solution with_height_stated(double z_m, double stated_m, double& found_m, bool& mirrored) {
  constexpr std::size_t kBeacon = 1;
  Scenario s = hall_scenario();
  for (SiteReceiver& r : s.site.receivers) r.position_m.z() = 0.4;
  s.site.beacons[kBeacon].position_m[2] = z_m;
  World world = must(simulate(s, 3));
  world.site.beacons[kBeacon].position_m[2] = stated_m;
  world.site.beacons[kBeacon].sigma_m[2] = 0.3;
  calib::Solution solution = solution_of(world);
  found_m = solution.state.beacon_p_map_m[kBeacon].z();
  mirrored = solution.beacon_mirrored[kBeacon];
  return solution;
}

TEST(MirrorImages, ABeaconNearTheReceiversHeightMayBeAboveOrBelow) {
  double found_m = 0.0;
  bool mirrored = false;
  // The image at 0.0 m is nearer to the given position, and is on the floor.
  static_cast<void>(with_height_stated(0.8, 0.35, found_m, mirrored));
  EXPECT_TRUE(mirrored);
  // The image at -0.4 m is nearer as well, and is under the floor.
  static_cast<void>(with_height_stated(1.2, 0.35, found_m, mirrored));
  EXPECT_FALSE(mirrored);
  EXPECT_NEAR(found_m, 1.2, 0.02);
  // With the true position in the site file, the image is ten sigmas away.
  static_cast<void>(with_height_stated(2.4, 2.2, found_m, mirrored));
  EXPECT_FALSE(mirrored);
  EXPECT_NEAR(found_m, 2.4, 0.02);
}

// Receivers whose known heights differ by centimetres determine on which side of them a beacon is.
TEST(MirrorImages, ReceiversAtDifferentHeightsTellAboveFromBelow) {
  constexpr std::size_t kBeacon = 1;
  Scenario s = hall_scenario();
  for (std::size_t r = 0; r < s.site.receivers.size(); ++r)
    s.site.receivers[r].position_m.z() = r % 2 == 0 ? 0.37 : 0.43;
  for (const double z_m : {0.8, 0.05})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      s.site.beacons[kBeacon].position_m[2] = z_m;
      World world = must(simulate(s, seed));
      world.site.beacons[kBeacon].position_m[2] = 0.8 - z_m;
      world.site.beacons[kBeacon].sigma_m[2] = 0.5;
      const calib::Solution solution = solution_of(world);
      EXPECT_FALSE(solution.beacon_mirrored[kBeacon]) << z_m << " m, seed " << seed;
      EXPECT_NEAR(solution.state.beacon_p_map_m[kBeacon].z(), z_m, 0.03) << "seed " << seed;
    }
}

// Equal squares, distributed over the arrivals of a pair or constant for it.
TEST(MirrorImages, WhatAPairKeepsCountsForLess) {
  constexpr std::size_t kBeacon = 1;
  const World world = must(simulate(hall_scenario(), 3));
  const calib::Problem problem = problem_of(world);
  const calib::SolveOptions options;
  calib::ProgressMonitor monitor(options);
  const calib::Approach approach = calib::approach(problem, options, monitor);
  const calib::ParameterLayout& layout = approach.estimate.layout;
  calib::AdjustedLog lower = approach;
  lower.estimate.x[layout.beacon[kBeacon][2]] -= 0.02;
  const auto against = [&](bool by_pair) {
    calib::AdjustedLog here = approach;
    std::vector<Trajectory>& trajectories = here.trajectories;
    const SharedState state = approach.estimate.state();
    std::map<std::size_t, int> arrivals;  // of each receiver
    for (Trajectory& t : trajectories)
      for (ArrivalObservation& a : t.arrivals)
        if (a.beacon.index() == kBeacon) {
          const std::size_t r = a.receiver.index();
          const double wanted = (by_pair ? r : static_cast<std::size_t>(arrivals[r]++)) % 2 == 0 ? 1.0 : -1.0;
          a.tof_s += (wanted - arrival_residual(t, a, state)) * a.sigma_s;
        }
    EXPECT_NEAR(arrival_residual(trajectories[0], trajectories[0].arrivals[0], state), 0.0, 4.0);
    lower.trajectories = trajectories;
    return calib::arrivals_against(problem, here, lower, 4.5);
  };
  const double spread = against(false), kept = against(true);
  EXPECT_GT(spread, 100.0);
  EXPECT_GT(kept, 0.0);
  EXPECT_LT(kept, 0.2 * spread);
}

TEST(MirrorImages, OfAWholeSiteNoSideIsGuessed) {
  EXPECT_EQ(solution_of(must(simulate(two_control_points(false), 3))).status, SolveStatus::kUndetermined);
  const World world = must(simulate(two_control_points(true), 3));  // counter-clockwise is no mirror image
  EXPECT_LT(worst_beacon_m(world, solution_of(world)), 0.3);
}

/// Beacons along one wall, off its line by decimetres and stated to that; one receiver, which stops before
/// the wall. Behind it all fits nearly as well, and one of five such sites ended there.
TEST(MirrorImages, ASiteAlongAWallIsNotItsImageInTheWall) {
  Scenario s = straight_line(false);
  const Eigen::Vector3d places[] = {{3.659, 0.774, 5.256}, {0.297, 0.739, 5.658}, {5.929, 0.345, 5.187},
                                    {3.657, 0.339, 5.658}, {5.472, 0.072, 4.438}, {1.008, 0.771, 4.447}};
  const double sigma_m[] = {0.0, 0.0, 0.1, 0.1, 0.3, 0.1};
  s.site.beacons.resize(6);
  for (std::size_t b = 0; b < 6; ++b)
    for (std::size_t i = 0; i < 3; ++i) {
      s.site.beacons[b].position_m[i] = places[b][static_cast<Eigen::Index>(i)];
      s.site.beacons[b].sigma_m[i] = sigma_m[b];
    }
  s.hall_m = {6.25, 2.69};
  s.site.noise.tof_sigma_s = 2.7e-5;
  s.path = {};
  s.path.epochs = 45;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const World world = must(simulate(s, seed));
    const calib::Solution solution = solution_of(world);
    EXPECT_TRUE(solution.contradictions.empty()) << seed << ": " << solution.message;
    EXPECT_LT(worst_beacon_m(world, solution), 0.2) << "seed " << seed << ": " << solution.message;
  }
}

TEST(MirrorImages, AWholeSiteIsReflectedInTheLineOfWhatIsKnown) {
  const World world = must(simulate(two_control_points(true), 3));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  const calib::ParameterLayout layout = calib::make_layout(problem, solution.state);
  const calib::AdjustedLog found{{layout, layout.vector_of(solution.state)}, solution.trajectories};
  calib::AdjustedLog image = found;
  ASSERT_TRUE(calib::reflect_site(problem, image));
  EXPECT_NEAR(image.estimate.state().beacon_p_map_m[4].y(), 0.1 - solution.state.beacon_p_map_m[4].y(), 1e-6);
  EXPECT_NEAR(image.estimate.state().beacon_p_map_m[4].x(), solution.state.beacon_p_map_m[4].x(), 1e-6);
  // Ranges do not distinguish them, bearings do.
  const calib::ConsensusCost here = calib::consensus_cost_of(problem, found, 4.0);
  const calib::ConsensusCost there = calib::consensus_cost_of(problem, image, 4.0);
  EXPECT_NEAR(there.arrivals, here.arrivals, 1e-3 * here.arrivals);
  EXPECT_EQ(calib::prefer(here, there, 1.0), calib::Preference::kFirst);
}

TEST(MirrorImages, ASiteThatIsKnownOrHeardByAnArrayIsNotReflected) {
  for (const Scenario& scenario : {straight_line(true), hall_scenario()}) {
    const calib::Problem problem = problem_of(must(simulate(scenario, 1)));
    const SharedState state = prior_state(problem.site);
    const calib::ParameterLayout layout = calib::make_layout(problem, state);
    calib::AdjustedLog log{{layout, layout.vector_of(state)}, problem.trajectories};
    EXPECT_FALSE(calib::reflect_site(problem, log));
  }
}

TEST(MirrorImages, BearingsThatDoNotFitAreListedAndTold) {
  Scenario s = hall_scenario();
  s.path.epochs = 30;
  s.site.noise.bearing_sigma_rad = 0.01;
  s.bearings = Scenario::Bearings{};
  World world = must(simulate(s, 4));
  std::size_t seen = 0;
  for (Bearing& b : world.run.bearings)
    if (b.reflector == BeaconId(2)) {
      b.bearing_rad = wrap_angle(b.bearing_rad + 1.0);
      ++seen;
    }
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  EXPECT_EQ(solution.left_out_bearings.size(), seen);
  for (const calib::LeftOutBearing& b : solution.left_out_bearings)
    EXPECT_EQ(world.run.bearings[b.bearing].reflector, BeaconId(2));
  EXPECT_THAT(solution.warnings, Contains(HasSubstr("beacon B2: ")));
}

/// A vehicle with measured poses stops along a curved line; at one stop it received a beacon a hundred times
/// from the position of its image.
struct EchoedStop {
  BeaconId beacon{1};
  std::int64_t epoch = 5;
  calib::Problem problem;
  SharedState here, there;  ///< true, and with the beacon at its image
  std::vector<Trajectory> trajectories;

  EchoedStop() {
    Scenario s = straight_line(true);
    s.path.waypoints_m = {{4.0, 5.5}, {10.0, 6.0}, {16.0, 5.5}};
    s.path.epochs = 10;
    s.log_poses = true;
    World world = must(simulate(s, 1));
    const calib::Solution clean = solution_of(world);  // by bearings, which tell the side
    world.run.bearings.clear();
    problem = problem_of(world);
    trajectories = problem.trajectories;
    Trajectory& t = trajectories[0];
    t.nodes = clean.trajectories[0].nodes;
    here = there = clean.state;
    there.beacon_p_map_m[beacon.index()].y() = 11.5 - here.beacon_p_map_m[beacon.index()].y();
    const auto heard = std::find_if(t.arrivals.begin(), t.arrivals.end(), [&](const ArrivalObservation& a) {
      return a.beacon == beacon && t.nodes[a.node].epoch == epoch;
    });
    ArrivalObservation echo = *heard;
    echo.tof_s -= echo.sigma_s * arrival_residual(t, echo, there);
    t.arrivals.insert(heard, 100, echo);
  }
  [[nodiscard]] calib::Preference preferred(const calib::ArrivalWeights& weights) const {
    const calib::ParameterLayout layout = calib::make_layout(problem, here);
    const auto consensus = [&](const SharedState& state) {
      return calib::consensus_cost_of(problem, {{layout, layout.vector_of(state)}, trajectories}, 4.0,
                                      weights);
    };
    return calib::prefer(consensus(here), consensus(there), 1.0);
  }
};

TEST(MirrorImages, AHundredEchoesOfOneStopDoNotDecide) {
  const EchoedStop echoed;
  EXPECT_EQ(echoed.preferred({}), calib::Preference::kSecond) << "counted one by one they do";
  EXPECT_EQ(echoed.preferred(calib::weights_by_place(echoed.problem, echoed.trajectories)),
            calib::Preference::kNeither);
}

TEST(MirrorImages, ArrivalsOfAPairAtOnePlaceCountAsFourAtMost) {
  const EchoedStop echoed;
  const calib::ArrivalWeights weights = calib::weights_by_place(echoed.problem, echoed.trajectories);
  ASSERT_EQ(weights.size(), 1U);
  const Trajectory& t = echoed.trajectories[0];
  ASSERT_EQ(weights[0].size(), t.arrivals.size());
  double of_the_pair = 0.0;
  for (std::size_t i = 0; i < t.arrivals.size(); ++i)
    if (t.nodes[t.arrivals[i].node].epoch == echoed.epoch && t.arrivals[i].beacon == echoed.beacon) {
      of_the_pair += weights[0][i];
    } else {
      EXPECT_EQ(weights[0][i], 1.0) << "arrival " << i;
    }
  EXPECT_NEAR(of_the_pair, 4.0, 1e-12);
}

TEST(MirrorImages, WhatIsPreferred) {
  using calib::prefer;
  using calib::Preference;
  EXPECT_EQ(prefer({100, 50}, {101, 400}, 1.0), Preference::kFirst);
  EXPECT_EQ(prefer({100, 400}, {101, 50}, 1.0), Preference::kSecond);
  EXPECT_EQ(prefer({100, 50}, {130, 50}, 1.0),
            Preference::kNeither);  // ranges alone: errors common to a place do that
  EXPECT_EQ(prefer({100, 50}, {400, 50}, 1.0), Preference::kFirst);
  EXPECT_EQ(prefer({100, 50}, {400, 50}, 3.0), Preference::kNeither);  // of nine times the variance
  EXPECT_EQ(prefer({100, 50}, {170, 30}, 1.0), Preference::kNeither);  // they contradict each other
}

/// A vehicle with its only receiver at the origin and measured positions: its heading has no effect.
Scenario without_heading() {
  Scenario s = straight_line(false);
  s.path.kind = PathKind::kStops;
  s.path.epochs = 40;
  s.log_poses = true;
  s.site.receivers[0].sigma_m.fill(0.002);
  return s;
}

TEST(Headings, ThatNothingHearsCostNoRedundancy) {
  World world = must(simulate(without_heading(), 5));
  world.run.pose_accuracy.heading_known = true;
  world.run.pose_accuracy.heading_sigma_rad = 3.2;
  const calib::Solution vague = solution_of(world);
  world.run.pose_accuracy.heading_known = false;
  const calib::Solution unknown = solution_of(world);
  ASSERT_EQ(unknown.status, SolveStatus::kConverged) << unknown.message;
  EXPECT_NEAR(unknown.statistics.redundancy, vague.statistics.redundancy, 1.0);
  EXPECT_NEAR(unknown.statistics.variance_factor, 1.0, 0.25);
}

/// One receiver two decimetres from the vehicle's origin: the direction of the vehicle is undetermined, and
/// all beacons result as if the receiver were at the origin.
TEST(Headings, AReceiverOffTheOriginWithoutHeadingsIsWhereTheVehicleStands) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Scenario s = hall_scenario();
    keep_one_receiver(s.site, {0.2, 0.0, 0.4}, 0.001);
    s.hearing_half_angle_rad = 3.2;
    s.range_m = 40.0;
    s.path.epochs = 30;
    World world = must(simulate(s, seed));
    const calib::Problem problem = problem_of(world);
    EXPECT_EQ(problem.site.receivers[0].taken_off_m, Eigen::Vector2d(0.2, 0.0));
    const calib::Solution solution = solution_of(world);
    EXPECT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
    const Deployment d = calib::make_deployment(problem, solution, {});
    EXPECT_EQ(d.receivers[0].position_m.head<2>(), Eigen::Vector2d(0.2, 0.0));
    EXPECT_TRUE(solution.contradictions.empty()) << seed;
    EXPECT_LT(worst_beacon_m(world, solution), 0.05) << seed;
    world.site.receivers[0].position_m.x() = 0.0;
    const calib::Solution on_origin = solution_of(world);
    for (std::size_t b = 0; b < world.site.beacons.size(); ++b)
      EXPECT_EQ(solution.state.beacon_p_map_m[b], on_origin.state.beacon_p_map_m[b]) << seed;
  }
}

TEST(Headings, ThatNothingHearsAreNotTurned) {
  World world = must(simulate(without_heading(), 6));
  world.run.pose_accuracy.heading_known = false;
  const calib::Solution solution = solution_of(world);
  for (const std::string& warning : solution.warnings)
    EXPECT_THAT(warning, Not(HasSubstr("faced the wrong way")));
}

}  // namespace mirror_images_test
}  // namespace octant::test
