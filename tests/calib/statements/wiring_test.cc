// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// False statements of the site file and of logs, told by reading them otherwise.
#include "calib/statements/wiring.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/problem/site_units.h"
#include "calib/statements/hints.h"
#include "calib/statements/pauses.h"
#include "calib/statements/readings.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A hall where a cart with four receivers, no square, stops.
World cart(int epochs = 40, std::uint64_t seed = 1, double echoes = 0.03) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  s.echo_fraction = echoes;
  const Eigen::Vector3d places[4] = {
      {0.35, 0.2, 0.3}, {0.35, -0.2, 0.3}, {-0.35, 0.2, 0.45}, {-0.35, -0.2, 0.45}};
  const char* names[4] = {"fl", "fr", "rl", "rr"};
  s.site.receivers.clear();
  for (int i = 0; i < 4; ++i)
    s.site.receivers.push_back({names[i], VehicleId(0), places[i], Eigen::Vector3d::Constant(0.001), {}});
  s.site.vehicles[0].first_receiver = 0;
  s.site.vehicles[0].receiver_count = 4;
  s.site.vehicles[0].array.reset();
  return must(simulate(s, seed));
}

std::vector<Contradiction> misreadings_of(const World& world) {
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  return calib::seems_misread(problem, solution) ? calib::find_misreadings(problem, solution)
                                                 : std::vector<Contradiction>{};
}

std::vector<std::vector<std::size_t>> orders(const std::vector<calib::Wiring>& wirings) {
  std::vector<std::vector<std::size_t>> all;
  for (const auto& w : wirings) all.push_back(w.order);
  return all;
}

TEST(Wiring, OfFourReceiversEveryOrderOnceTheLikelierFirst) {
  const World world = cart(2);
  const auto all = calib::wirings(world.site, VehicleId(0));
  auto sorted = orders(all);
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted.size(), 23U);
  EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end());
  EXPECT_THAT(all[0].order, ::testing::ElementsAre(1, 0, 3, 2)) << "left and right";
  EXPECT_THAT(all[0].words, HasSubstr("mirrored"));
  EXPECT_EQ(all[1].words, "receivers fl and fr of robot are exchanged");
}

TEST(Wiring, OfAnOctagonExchangesTurnsAndReflections) {
  const World world = must(simulate(hall_scenario(), 1));
  ASSERT_EQ(world.site.receivers.size(), 8U);
  const auto all = orders(calib::wirings(world.site, VehicleId(0)));
  EXPECT_EQ(all.size(), 28U + 7U + 8U);
  for (std::size_t shift = 1; shift < 8; ++shift) {
    std::vector<std::size_t> turned(8);
    for (std::size_t i = 0; i < 8; ++i) turned[i] = (i + shift) % 8;
    EXPECT_NE(std::find(all.begin(), all.end(), turned), all.end()) << shift;
  }
}

TEST(Wiring, OneReceiverHasNone) {
  World world = cart(2);
  world.site.receivers.resize(1);
  world.site.vehicles[0].receiver_count = 1;
  EXPECT_THAT(calib::wirings(world.site, VehicleId(0)), IsEmpty());
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
    ASSERT_EQ(found.size(), 1U) << words;
    EXPECT_EQ(found[0].kind, ContradictionKind::kWiring);
    EXPECT_THAT(found[0].found, HasSubstr(words));
    EXPECT_GT(found[0].sigmas, 10.0);
  }
}

/// Three control points are all the datum, and of the other beacons nothing is known.
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

std::vector<Contradiction> explained(const World& world) {
  const calib::Problem problem = problem_of(world);
  calib::Solution solution = calib::solve(problem);
  calib::explain(problem, problem, solution, {});
  return solution.contradictions;
}

// Each of the three can be blamed by itself, as it may move to where it agrees with the others.
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

TEST(Readings, NameTheBeaconsThatAloneAreInCentimetres) {
  World world = cart();
  for (const std::size_t b : {1U, 3U})
    for (auto& x : world.site.beacons[b].position_m) *x *= 100;
  const auto some = calib::beacons_in_unit(world.site, calib::length_units()[0]);
  EXPECT_EQ(std::count(some.begin(), some.end(), true), 2);
  EXPECT_TRUE(some[1] && some[3]);
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

TEST(Readings, NameAMirroredPoseFrame) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  s.log_poses = true;
  World world = must(simulate(s, 2));
  for (TimedPose& p : world.run.poses) {
    p.T_map_vehicle = Pose::planar(p.T_map_vehicle.translation_m.x(), -p.T_map_vehicle.translation_m.y(),
                                   -p.T_map_vehicle.heading_rad());
  }
  const auto found = misreadings_of(world);
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found[0].found, HasSubstr("left-handed"));
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
  for (TimedPose& p : world.run.poses) {
    p.T_map_vehicle = Pose::planar(p.T_map_vehicle.translation_m.x(), -p.T_map_vehicle.translation_m.y(),
                                   -p.T_map_vehicle.heading_rad());
  }
  const auto found = misreadings_of(world);
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found[0].found, HasSubstr("left-handed"));
}

TEST(Explain, PutsTheCulpritInPlaceOfAMeasurementThatWouldNotHelp) {
  const calib::Problem problem = problem_of(in_another_unit(cart(), 100.0, false));
  calib::Solution solution = calib::solve(problem);
  ASSERT_EQ(solution.status, calib::SolveStatus::kUndetermined);
  calib::explain(problem, problem, solution, {});
  ASSERT_EQ(solution.contradictions.size(), 1U);
  EXPECT_THAT(solution.message, ::testing::Not(HasSubstr("approximate positions")));
  EXPECT_THAT(solution.weak, IsEmpty());
}

TEST(SiteUnits, ADelayLongerThanEveryTimeOfFlightIsInAnotherUnit) {
  World world = cart(5);
  world.site.timing.delay_per.beacon = true;
  for (const auto& [delay_s, unit] : {std::pair{100.0, "microseconds"}, {0.1, "milliseconds"}}) {
    world.site.timing.delay_s = delay_s;
    const auto result = calib::make_problem(world.site, {world.run});
    ASSERT_FALSE(result);
    EXPECT_THAT(result.error().message(), HasSubstr(unit));
  }
  world.site.timing.delay_s = 1e-4;
  EXPECT_TRUE(calib::make_problem(world.site, {world.run}));
  world.site.beacons[1].delay_s = 100.0;
  const auto result = calib::make_problem(world.site, {world.run});
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message(), HasSubstr("delay_s of beacon " + world.site.beacons[1].name));
}

TEST(SiteUnits, OfAPlace) {
  const Eigen::Vector3d stated(32.8084, 16.4042, 9.84252), found(10.0, 5.0, 3.0);
  const auto unit = calib::unit_of_place(stated, found, 0.02);
  ASSERT_TRUE(unit);
  EXPECT_STREQ(unit->name, "feet");
  EXPECT_FALSE(calib::unit_of_place(found, found, 0.02));
  EXPECT_FALSE(calib::unit_of_place({20.0, 5.0, 3.0}, found, 0.02));
}

TEST(Hints, PlacesWithoutASigma) {
  World world = cart(3);
  EXPECT_THAT(calib::site_hints(world.site), IsEmpty());
  for (SiteBeacon& b : world.site.beacons) b.sigma_m = {};
  ASSERT_EQ(calib::site_hints(world.site).size(), 1U);
  EXPECT_THAT(calib::site_hints(world.site)[0].text, HasSubstr("start only"));
}

TEST(Hints, OfALongLogAreThoseOfAShortOne) {
  World world = cart(400);  // some ten thousand rows
  const std::vector<Arrival> once = world.run.arrivals;
  for (int copy = 1; copy < 6; ++copy)
    for (Arrival a : once) {
      a.epoch += 400 * copy;
      a.time_s += 1e4 * copy;
      world.run.arrivals.push_back(a);
    }
  ASSERT_GT(world.run.arrivals.size(), 40'000U);
  EXPECT_THAT(calib::log_hints(world.site, {world.run}), IsEmpty());
  for (Arrival& a : world.run.arrivals) a.tof_s *= 2;
  const auto found = calib::log_hints(world.site, {world.run});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, "two_way");
}

TEST(Pauses, NumberStopsOnlyWhereThereAreSome) {
  World world = cart(20);
  const std::vector<Arrival> stated = world.run.arrivals;
  for (Arrival& a : world.run.arrivals) a.epoch = kNoEpoch;
  world.run.has_epochs = false;
  EXPECT_EQ(calib::number_stops(world.run), 20U);
  for (std::size_t i = 0; i < stated.size(); ++i) ASSERT_EQ(world.run.arrivals[i].epoch, stated[i].epoch);
  EXPECT_EQ(calib::number_stops(world.run), 0U) << "it has epochs now";

  World evenly = cart(20);
  evenly.run.has_epochs = false;
  for (std::size_t i = 0; i < evenly.run.arrivals.size(); ++i)
    evenly.run.arrivals[i].time_s = 0.05 * static_cast<double>(i);
  EXPECT_EQ(calib::number_stops(evenly.run), 0U);
}

}  // namespace
}  // namespace octant::test
