// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// False assumptions in site files and logs, found by hypotheses.
#include "calib/readings/readings.h"
#include "calib/readings/explain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/problem/site_units.h"
#include "calib/readings/wiring.h"
#include "models/simulator/random.h"
#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace readings_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<Contradiction> misreadings_of(const World& world) {
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  return calib::seems_misread(problem, solution) ? calib::find_misreadings(problem, solution)
                                                 : std::vector<Contradiction>{};
}

TEST(Readings, NameReceiversThatAreWiredOtherwise) {
  const std::vector<std::pair<std::vector<std::size_t>, const char*>> wrong = {
      {{1, 0, 2, 3}, "receivers fl and fr of robot are exchanged"},
      {{1, 0, 3, 2}, "mirrored"},
      {{1, 3, 0, 2}, "turned"},
      {{3, 1, 2, 0}, "receivers fl and rr of robot are exchanged"}};
  std::uint64_t seed = 1;
  for (const auto& [order, words] : wrong) {
    World world = cart(40, seed++);
    world.site = calib::rewired(world.site, VehicleId(0), {order, ""});
    const auto found = misreadings_of(world);
    // A mirrored map is the same to the ranges as mirrored receivers.
    ASSERT_EQ(found.size(), std::string(words) == "mirrored" ? 2U : 1U) << words;
    if (found.size() > 1) EXPECT_THAT(found[1].remedy, testing::StartsWith("or else "));
    EXPECT_EQ(found[0].kind, ContradictionKind::kWiring);
    EXPECT_THAT(found[0].found, HasSubstr(words));
    EXPECT_GT(found[0].sigmas, 10.0);
  }
}

/// Three control points are the whole datum, and the other beacons are unknown.
World three_points(std::uint64_t seed) {
  World world = cart(40, seed);
  int points = 0;
  for (SiteBeacon& b : world.site.beacons) {
    if (b.is_control_point() && ++points <= 3) continue;
    b.position_m = {};
    b.sigma_m = {};
  }
  return world;
}

// The adjustment of the whole log bends to such a jump: delays, receivers and places are blamed for it.
TEST(Readings, NameAClockThatJumped) {
  for (const auto& [share, jump_s] : {std::pair{0.66, -3e-3}, {0.3, 1e-3}, {0.5, 2e-4}}) {
    World world = must(simulate(hall_scenario(), 5));
    EXPECT_THAT(explained(world), IsEmpty()) << "before it jumped";
    const double at_s = jump_clock(world, share, jump_s);
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 1U) << jump_s;
    EXPECT_EQ(found[0].kind, ContradictionKind::kLog);
    EXPECT_THAT(found[0].found, HasSubstr(fmt::format("from {:.6g} s on", at_s)));
    EXPECT_THAT(found[0].found, HasSubstr(jump_s > 0 ? "longer" : "shorter"));
  }
}

TEST(Readings, NameAClockThatJumpedDuringADrive) {
  const World before = must(simulate(drive_scenario(40.0), 5));
  EXPECT_THAT(explained(before), IsEmpty());
  for (const auto& [share, jump_s] : {std::pair{0.66, -3e-3}, {0.3, 2e-4}}) {
    World world = before;
    static_cast<void>(jump_clock_of_drive(world, share, jump_s));
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 1U) << jump_s;
    EXPECT_EQ(found[0].kind, ContradictionKind::kLog);
    EXPECT_THAT(found[0].found, HasSubstr(jump_s > 0 ? "longer" : "shorter"));
  }
}

/// Receivers whose mirror image is not one of their other wirings.
World lopsided_cart(std::uint64_t seed) {
  World world = cart(40, seed);
  for (int i = 0; i < 4; ++i)
    world.site.receivers[static_cast<std::size_t>(i)].position_m.y() += i == 1 ? 0.12 : 0.0;
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  s.site = world.site;
  return must(simulate(s, seed));
}

TEST(Readings, NameReceiversOrAMapThatAreMirrored) {
  World receivers = lopsided_cart(2), map = receivers;
  EXPECT_THAT(explained(receivers), IsEmpty()) << "as they are";
  for (SiteReceiver& r : receivers.site.receivers) r.position_m.y() *= -1;
  for (SiteBeacon& b : map.site.beacons) std::swap(b.position_m[0], b.position_m[1]);
  for (const World& world : {receivers, map}) {
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 2U) << "no pose and no odometry tells them apart";
    EXPECT_EQ(found[0].kind, ContradictionKind::kWiring);
    EXPECT_THAT(found[0].found, HasSubstr("mirrored"));
    EXPECT_EQ(found[1].kind, ContradictionKind::kExchanged);
    EXPECT_THAT(found[1].found, HasSubstr("map is mirrored"));
  }
}

TEST(Readings, NameTheBeaconsThatAreInFeet) {
  for (World world : {cart(), must(simulate(drive_scenario(), 5))}) {
    std::string names;
    for (std::size_t b = 0; b < world.site.beacons.size(); b += 2) {
      for (auto& x : world.site.beacons[b].position_m)
        if (x) *x /= 0.3048;
      names += (b > 0 ? ", " : "beacons ") + world.site.beacons[b].name;
    }
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, ContradictionKind::kUnits);
    EXPECT_THAT(found[0].subject, HasSubstr(names));
    EXPECT_THAT(found[0].found, HasSubstr("feet"));
  }
}

// In centimetres its distance from its position is unchanged, and its position is still ignored.
TEST(Readings, NameTheUnitInWhichAPlaceIsRightAndNotOneInWhichItIsDisregarded) {
  std::size_t tried = 0;
  for (std::size_t b = 0; b < cart().site.beacons.size(); ++b) {
    World world = cart();
    if (world.site.beacons[b].is_control_point()) continue;
    for (auto& x : world.site.beacons[b].position_m) *x *= 1000.0;
    if (!calib::beacons_in_unit(world.site, {"centimetres", 0.01})[b]) continue;
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_THAT(found[0].found, HasSubstr("millimetres"));
    ++tried;
  }
  EXPECT_GT(tried, 0U);
}

// Receivers whose cables are exchanged repeatedly have no explanation.
TEST(Explain, EarlyArrivalsBeyondChanceContradictWhateverTheirCauseIs) {
  World world = cart();
  for (Arrival& a : world.run.arrivals)
    a.receiver = ReceiverId((a.receiver.index() + static_cast<std::size_t>(a.epoch % 3 == 0 ? 1 : 0) +
                             static_cast<std::size_t>(a.epoch % 3 == 1 ? 3 : 0)) %
                            4);
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kLog);
  EXPECT_THAT(found[0].found, HasSubstr("early"));
}

// Each of the three can be blamed alone, because it may move to where it agrees with the others.
TEST(Readings, NameTwoOfThreeControlPointsThatAreExchanged) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    World world = three_points(seed);
    EXPECT_THAT(explained(world), IsEmpty()) << "before they are exchanged";
    std::vector<SiteBeacon*> points;
    for (SiteBeacon& b : world.site.beacons)
      if (b.is_control_point()) points.push_back(&b);
    ASSERT_EQ(points.size(), 3U);
    std::swap(points[0]->position_m, points[2]->position_m);
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 1U) << seed;
    EXPECT_EQ(found[0].kind, ContradictionKind::kExchanged);
    EXPECT_EQ(found[0].subject, points[0]->name + ", " + points[2]->name);
    EXPECT_GT(found[0].sigmas, 10.0);
  }
}

TEST(Readings, AccuseNobodyOfAnHonestWorldWithManyEchoes) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const World world = cart(40, seed, 0.3);
    const calib::Problem problem = problem_of(world);
    EXPECT_THAT(calib::find_misreadings(problem, calib::solve(problem)), IsEmpty()) << seed;
  }
  const World world = cart(40, 3);
  EXPECT_FALSE(calib::seems_misread(problem_of(world), solution_of(world)));
}

World in_another_unit(World world, double factor, bool sigmas) {
  for (SiteBeacon& b : world.site.beacons)
    for (std::size_t i = 0; i < 3; ++i) {
      if (b.position_m[i]) *b.position_m[i] *= factor;
      if (sigmas && b.sigma_m[i]) *b.sigma_m[i] *= factor;
    }
  return world;
}

TEST(Readings, NameTheUnitOfPositions) {
  const std::tuple<double, bool, const char*> units[] = {{100.0, false, "centimetres"},
                                                         {100.0, true, "centimetres"},
                                                         {1000.0, true, "millimetres"},
                                                         {1 / 0.3048, true, "feet"}};
  for (const auto& [factor, sigmas, name] : units) {
    const auto found = misreadings_of(in_another_unit(cart(), factor, sigmas));
    ASSERT_EQ(found.size(), 1U) << name;
    EXPECT_EQ(found[0].kind, ContradictionKind::kUnits);
    EXPECT_THAT(found[0].found, HasSubstr(name));
  }
}

// The speed may absorb it if its prior is wide, but is not the cause.
TEST(Readings, NameTwoWayTimesInPlaceOfASpeedThatBentToThem) {
  World world = must(simulate(hall_scenario(), 5));
  for (Arrival& a : world.run.arrivals) a.tof_s *= 2;
  const calib::Problem problem = problem_of(world);
  calib::Solution solution = calib::solve(problem);
  calib::explain(problem, problem, solution, {.diagnosis_s = INFINITY});
  ASSERT_EQ(solution.contradictions.size(), 1U);
  EXPECT_EQ(solution.contradictions[0].kind, ContradictionKind::kRanging);
}

TEST(Readings, NameTwoWayTimesAndMissingEpochs) {
  World twice = cart();
  for (Arrival& a : twice.run.arrivals) a.tof_s *= 2;
  auto found = misreadings_of(twice);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].found, HasSubstr("there and back"));

  for (const bool all_zero : {false, true}) {
    World world = cart();
    world.run.has_epochs = all_zero;
    for (Arrival& a : world.run.arrivals) a.epoch = all_zero ? 0 : kNoEpoch;
    found = misreadings_of(world);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, ContradictionKind::kEpochs);
    EXPECT_THAT(found[0].found, HasSubstr("40 groups"));
    EXPECT_THAT(found[0].remedy, HasSubstr("column epoch"));
  }
}

/// With its poses in a frame whose y points the other way.
void expect_left_handed_once_mirrored(World& world) {
  for (TimedPose& p : world.run.poses) {
    p.T_map_vehicle = Pose::planar(p.T_map_vehicle.translation_m.x(), -p.T_map_vehicle.translation_m.y(),
                                   -p.T_map_vehicle.heading_rad());
  }
  const auto found = misreadings_of(world);
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found[0].found, HasSubstr("left-handed"));
}

TEST(Readings, NameAMirroredPoseFrame) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  s.log_poses = true;
  World world = must(simulate(s, 2));
  expect_left_handed_once_mirrored(world);
}

// One pose a stop, so that a lag of the poses would take them away, and all would fit.
TEST(Readings, NameAMirroredPoseFrameOfStops) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  s.log_poses = true;
  World world = must(simulate(s, 2));
  std::vector<TimedPose> of_stops;
  for (std::size_t i = 0; i < world.run.arrivals.size(); ++i) {
    const Arrival& arrival = world.run.arrivals[i];
    if (i > 0 && arrival.epoch == world.run.arrivals[i - 1].epoch) continue;
    Pose pose;
    ASSERT_TRUE(interpolate_poses(world.run.poses, arrival.time_s, 1.0, pose));
    for (const double later_s : {0.0, 0.5}) of_stops.push_back({arrival.time_s + later_s, pose});
  }
  world.run.poses = of_stops;
  expect_left_handed_once_mirrored(world);
}

// An error without a hypothesis: without the poses everything agrees.
TEST(Readings, NameMeasuredPosesThatFitInNoWay) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  s.log_poses = true;
  World world = must(simulate(s, 2));
  EXPECT_THAT(explained(world), IsEmpty()) << "as they are";
  for (TimedPose& pose : world.run.poses)
    std::swap(pose.T_map_vehicle.translation_m.x(), pose.T_map_vehicle.translation_m.y());
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kPoses);
  EXPECT_THAT(found[0].found, HasSubstr("fit without them"));
}

/// A drive with odometry and measured poses of a vehicle that turns and brakes.
World measured_drive(std::uint64_t seed) {
  Scenario s = drive_scenario();
  s.log_poses = true;
  return must(simulate(s, seed));
}

// Receivers that seem elsewhere on the vehicle, or control points that bend to it, were blamed.
TEST(Readings, NameMeasuredPosesThatAreStampedLateOrEarly) {
  for (const double lag_s : {0.15, -0.06}) {
    World world = measured_drive(5);
    for (TimedPose& pose : world.run.poses) pose.time_s += lag_s;
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, ContradictionKind::kPoses);
    const std::string before = "stamped ";
    const std::size_t at = found[0].found.find(before);
    ASSERT_NE(at, std::string::npos) << found[0].found;
    EXPECT_NEAR(std::stod(found[0].found.substr(at + before.size())), std::abs(lag_s),
                0.02 * std::abs(lag_s));
    EXPECT_THAT(found[0].found, HasSubstr(lag_s > 0 ? "s late" : "s early"));
  }
}

TEST(Readings, NameMeasuredPosesOfAnotherPointOfTheVehicle) {
  Scenario stops = hall_scenario();
  stops.path.epochs = 40;
  stops.log_poses = true;
  for (World world : {measured_drive(6), must(simulate(stops, 2))}) {
    EXPECT_THAT(explained(world), IsEmpty()) << "as they are";
    const Eigen::Vector3d prism(0.11, -0.07, 0.0);
    for (TimedPose& pose : world.run.poses)
      pose.T_map_vehicle.translation_m += pose.T_map_vehicle.rotation * prism;
    const auto found = explained(world);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, ContradictionKind::kPoses);
    EXPECT_THAT(found[0].found, HasSubstr("of a point at (0.1"));
    EXPECT_THAT(found[0].found, HasSubstr(", -0.0"));
  }
}

// A constant error of a beacon-receiver pair is not a lag, though a lag explains a part of it.
TEST(Readings, AccuseNoClockOfErrorsThatPairsKeep) {
  World world = measured_drive(7);
  Random random(7, 1);
  std::map<std::pair<int, int>, double> bias_s;
  for (Arrival& a : world.run.arrivals)
    a.tof_s += bias_s
                   .try_emplace({a.beacon.value, a.receiver.value},
                                5 * world.site.noise.tof_sigma_s * random.normal())
                   .first->second;
  for (const Contradiction& c : explained(world)) EXPECT_NE(c.kind, ContradictionKind::kPoses) << in_words(c);
}

// Wheels of another diameter: control points and delays were blamed.
TEST(Readings, NameOdometryWhoseWayIsTooLong) {
  World world = must(simulate(drive_scenario(), 5));
  for (OdometryStep& step : world.run.odometry) step.dx_m *= 1.05, step.dy_m *= 1.05;
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kLog);
  EXPECT_THAT(found[0].found, HasSubstr("its way is"));
  EXPECT_THAT(found[0].found, HasSubstr("% too long"));
}

TEST(Readings, NameOdometryThatTurnsClockwise) {
  World world = must(simulate(drive_scenario(), 5));
  EXPECT_THAT(explained(world), IsEmpty()) << "as it is";
  for (OdometryStep& step : world.run.odometry) step.dheading_rad = -step.dheading_rad;
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kLog);
  EXPECT_THAT(found[0].subject, HasSubstr("odometry.csv"));
  EXPECT_THAT(found[0].found, HasSubstr("clockwise"));
}

/// Where the poses alone carry the map, everything agrees with a mirrored frame to a noise sixty times too
/// large.
TEST(Readings, NameAMirroredPoseFrameWhereNoBeaconIsKnown) {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  s.echo_fraction = 0.05;
  s.log_poses = true;
  World world = must(simulate(s, 3));
  for (SiteBeacon& b : world.site.beacons) b.position_m = b.sigma_m = {};
  expect_left_handed_once_mirrored(world);
}

TEST(Explain, PutsTheCulpritInPlaceOfAMeasurementThatWouldNotHelp) {
  const calib::Problem problem = problem_of(in_another_unit(cart(), 100.0, false));
  calib::Solution solution = calib::solve(problem);
  ASSERT_EQ(solution.status, calib::SolveStatus::kUndetermined);
  calib::explain(problem, problem, solution, {.diagnosis_s = INFINITY});
  ASSERT_EQ(solution.contradictions.size(), 1U);
  EXPECT_THAT(solution.message, ::testing::Not(HasSubstr("approximate positions")));
  EXPECT_THAT(solution.weak, IsEmpty());
}

}  // namespace readings_test
}  // namespace octant::test
