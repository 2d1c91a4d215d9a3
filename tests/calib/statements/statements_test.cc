// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Tests of the user's assumptions by the data, and of the consistency of the recording.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/statements/halls.h"

namespace octant::test {
namespace statements_test {

using calib::SolveStatus;
using testing::AnyOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// The one contradiction that is to be found.
Contradiction only(const calib::Solution& solution) {
  EXPECT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  EXPECT_EQ(solution.contradictions.size(), 1U) << all_in_words(solution);
  return solution.contradictions.empty() ? Contradiction{} : solution.contradictions.front();
}

TEST(Statements, TruthfulSitesAreNotContradicted) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Scenario s = sixty_stops();
    s.echo_fraction = seed % 2 == 0 ? 0.1 : 0.0;
    EXPECT_THAT(all_in_words(solution_of(must(simulate(s, seed)))), IsEmpty()) << "seed " << seed;
  }
}

TEST(Statements, AControlPointThatIsOffIsNamed) {
  for (const double off_m : {0.1, 1.0}) {
    World world = must(simulate(sixty_stops(), 3));
    *world.site.beacons[3].position_m[0] += off_m;
    const Contradiction c = only(solution_of(world));
    EXPECT_EQ(c.kind, ContradictionKind::kControlPoint);
    EXPECT_EQ(c.subject, "B3");
    EXPECT_GT(c.sigmas, 5.0);
    EXPECT_THAT(c.remedy, HasSubstr("B3"));
  }
}

TEST(Statements, ExchangedControlPointsAreNamed) {
  Scenario s = sixty_stops();
  s.site.beacons[1].sigma_m = {
      0.0, 0.0, 0.0};  // a fourth one: of three, two that are exchanged leave a single good one
  World world = must(simulate(s, 4));
  std::swap(world.site.beacons[0].position_m, world.site.beacons[6].position_m);
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kExchanged);
  EXPECT_THAT(c.subject, AnyOf("B0, B6", "B6, B0"));
}

TEST(Statements, DegreesFahrenheitAreRecognised) {
  World world = must(simulate(sixty_stops(), 5));
  world.site.medium.temperature_degC = 1.8 * world.site.medium.temperature_degC + 32;
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kSpeed);
  EXPECT_THAT(c.found, HasSubstr("Fahrenheit"));
  EXPECT_THAT(c.remedy, HasSubstr("Celsius"));
}

TEST(Statements, AThermometerThatIsOffIsNotTakenForFahrenheit) {
  Scenario s = sixty_stops();
  s.site.speed_sigma_mps = 0.3;
  s.true_temperature_offset_degC = -8.0;
  const Contradiction c = only(solution_of(must(simulate(s, 6))));
  EXPECT_EQ(c.kind, ContradictionKind::kSpeed);
  EXPECT_THAT(c.found, testing::Not(HasSubstr("Fahrenheit")));
  EXPECT_THAT(c.remedy, HasSubstr("thermometer"));
}

TEST(Statements, AReceiverOutOfItsPlaceIsNamed) {
  World world = must(simulate(sixty_stops(), 7));
  world.site.receivers[2].position_m.x() += 0.04;
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kReceiver);
  EXPECT_EQ(c.subject, "robot/" + world.site.receivers[2].name);
}

TEST(Statements, ADelayBlockThatIsMissingIsNamed) {
  World world = must(simulate(sixty_stops(), 8));
  world.site.timing.delay_per = {};
  world.site.timing.delay_s = world.site.timing.delay_sigma_s = 0.0;
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kDelay);
  EXPECT_THAT(c.remedy, HasSubstr("delay_per"));
}

// Beacons that differ in their delays got a good control point blamed.
TEST(Statements, OneDelayForAllIsNamedWhereBeaconsDiffer) {
  int named = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Scenario s = sixty_stops();
    s.true_delay_s = {0.0, 2e-4};
    World world = must(simulate(s, seed));
    world.site.timing.delay_per = {.site = true};
    const calib::Solution solution = solution_of(world);
    for (const Contradiction& c : solution.contradictions) {
      EXPECT_EQ(c.kind, ContradictionKind::kDelay) << "seed " << seed << ": " << in_words(c);
      EXPECT_THAT(c.remedy, HasSubstr("timing.delay_per: beacon"));
    }
    named += solution.contradictions.size() == 1 ? 1 : 0;
  }
  EXPECT_GE(named, 5);
}

// One common delay, and a wrong control point: the point is the cause.
TEST(Statements, OneDelayForAllIsNotBlamedForAControlPoint) {
  Scenario s = sixty_stops();
  s.true_delay_s = {1e-4, 1e-4};
  World world = must(simulate(s, 3));
  world.site.timing.delay_per = {.site = true};
  *world.site.beacons[3].position_m[0] += 0.1;
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kControlPoint);
  EXPECT_EQ(c.subject, "B3");
}

// Control points were blamed for the air.
TEST(Statements, ASpeedThatIsHeldAndWrongIsNamed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Scenario s = sixty_stops();
    s.true_speed_offset_mps.reset();
    s.true_temperature_offset_degC = 10.0;
    World world = must(simulate(s, seed));
    world.site.speed_sigma_mps = 0.0;
    const Contradiction c = only(solution_of(world));
    EXPECT_EQ(c.kind, ContradictionKind::kSpeed) << in_words(c);
    EXPECT_THAT(c.stated, HasSubstr("held fixed"));
  }
}

TEST(Statements, DelaysThatAreOffTogetherAreNamedTogether) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Scenario s = sixty_stops();
    s.true_delay_s = {2e-5, 2e-4};
    World world = must(simulate(s, seed));
    world.site.timing.delay_s = 0.0;
    world.site.timing.delay_sigma_s = 1e-6;
    const Contradiction c = only(solution_of(world));
    EXPECT_EQ(c.kind, ContradictionKind::kDelay) << in_words(c);
    EXPECT_EQ(c.subject, "all beacons");
    EXPECT_THAT(c.remedy, HasSubstr("delay_sigma_s"));
  }
}

TEST(Statements, HeightsThatCountFromElsewhereAreOneContradiction) {
  World world = must(simulate(sixty_stops(), 3));
  for (SiteBeacon& b : world.site.beacons) *b.position_m[2] += 0.5;
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kControlPoint);
  EXPECT_THAT(c.found, HasSubstr("lower than stated"));
  EXPECT_THAT(c.remedy, HasSubstr("z = 0 is the floor"));
}

TEST(Statements, ADelayFarFromItsPriorIsNamed) {
  Scenario s = sixty_stops();
  s.true_delay_s = {9e-5, 1.1e-4};
  World world = must(simulate(s, 9));
  world.site.timing.delay_sigma_s = 2e-5;
  for (Arrival& a : world.run.arrivals)
    if (a.beacon.index() == 4) a.tof_s += 3e-4;
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kDelay);
  EXPECT_EQ(c.subject, "B4");
}

TEST(Statements, ATapeThatIsOffIsNamed) {
  World world = must(simulate(sixty_stops(), 10));
  const double true_m = (world.truth.beacons[1].position_m - world.truth.beacons[5].position_m).norm();
  world.site.distances.push_back({BeaconId(1), BeaconId(5), true_m + 0.3, 0.003});
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.kind, ContradictionKind::kDistance);
  EXPECT_THAT(c.subject, HasSubstr("B5"));
}

TEST(Statements, NoiseThatIsLargerThanStatedIsNoContradiction) {
  World world = must(simulate(sixty_stops(), 11));
  world.site.noise.tof_sigma_s /= 4;
  const calib::Solution solution = solution_of(world);
  EXPECT_THAT(all_in_words(solution), IsEmpty());
  EXPECT_THAT(solution.warnings, Contains(HasSubstr("noise")));
}

TEST(Statements, ErrorsThatAPairKeepsAreNoContradiction) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Scenario s = hall_scenario();
    World world = must(simulate(s, seed));
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    std::map<std::pair<std::size_t, std::size_t>, std::pair<double, std::int64_t>>
        bias;  // of each pair, and of which epoch
    const double memory = std::exp(-1.0 / 20);
    for (Arrival& a : world.run.arrivals) {
      auto [at, is_new] =
          bias.try_emplace({a.beacon.index(), a.receiver.index()}, std::pair{normal(engine), a.epoch});
      for (; at->second.second < a.epoch; ++at->second.second)
        at->second.first = memory * at->second.first + std::sqrt(1 - memory * memory) * normal(engine);
      a.tof_s += 3e-5 * at->second.first;
    }
    EXPECT_THAT(all_in_words(solution_of(world)), IsEmpty()) << "seed " << seed;
  }
}

struct MovedBeacon {
  World world;
  double after_s = 0.0;  ///< relative to the start of the recording
};

/// B4 is moved along its rays after some share of the recording.
MovedBeacon with_moved_beacon(std::uint64_t seed, double by_m, double share) {
  Scenario s = without_noise(sixty_stops());
  MovedBeacon moved{must(simulate(s, seed))};
  *s.site.beacons[4].position_m[1] += by_m;
  const World later = must(simulate(s, seed));
  World& world = moved.world;
  world.site.noise.tof_sigma_s = 1e-5;
  const double first_s = world.run.arrivals.front().time_s, last_s = world.run.arrivals.back().time_s;
  moved.after_s = share * (last_s - first_s);
  take_over(
      later, [&](const Arrival& a) { return a.beacon.index() == 4 && a.time_s > first_s + moved.after_s; },
      world);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0.0, 1e-5);
  for (Arrival& a : world.run.arrivals) a.tof_s += normal(engine);
  return moved;
}

TEST(Agreement, ABeaconThatMovedIsNamedAndWhen) {
  for (const double by_m : {0.05, 0.1})
    for (const double share : {0.3, 0.5, 0.72}) {
      const MovedBeacon moved = with_moved_beacon(12, by_m, share);
      const Contradiction c = only(solution_of(moved.world));
      EXPECT_EQ(c.kind, ContradictionKind::kBeacon);
      EXPECT_EQ(c.subject, "B4");
      double found_s = 0.0;
      const std::size_t at = c.found.find("some ");
      ASSERT_NE(at, std::string::npos) << c.found;
      ASSERT_EQ(std::sscanf(c.found.c_str() + at, "some %lf s into", &found_s), 1) << c.found;
      // Between the stops before and after it at which the beacon was received.
      EXPECT_NEAR(found_s, moved.after_s, 20.0) << by_m << " m, " << share << ": " << c.found;
    }
}

// Moves were searched among rejected arrivals only.
TEST(Agreement, AMoveThatRejectsFewArrivalsIsNamed) {
  for (std::uint64_t seed = 12; seed < 15; ++seed)
    EXPECT_THAT(all_in_words(solution_of(with_moved_beacon(seed, 0.03, 0.5).world)), HasSubstr("B4"));
}

// Few stops do not determine whether a beacon moved or errs there, however many arrivals they have.
TEST(Agreement, ErrorsOfTheLastStopsAreNoMove) {
  for (std::uint64_t seed = 12; seed < 15; ++seed) {
    MovedBeacon moved = with_moved_beacon(seed, 0.1, 0.96);
    MeasurementLog& run = moved.world.run;
    std::vector<Arrival> more;
    for (const Arrival& a : run.arrivals)
      if (a.time_s > run.arrivals.front().time_s + moved.after_s) more.insert(more.end(), 10, a);
    run.arrivals.insert(run.arrivals.end(), more.begin(), more.end());
    std::ranges::stable_sort(run.arrivals, {}, &Arrival::time_s);
    EXPECT_THAT(all_in_words(solution_of(moved.world)), Not(HasSubstr("to move by"))) << "seed " << seed;
  }
}

TEST(Agreement, ABeaconThatIsLateBehindAnObstacleIsNamedAndHarmsNothing) {
  World world = must(simulate(sixty_stops(), 13));
  for (Arrival& a : world.run.arrivals)
    if (a.beacon.index() == 5 && a.epoch % 2 == 0) a.tof_s += 0.3 / 343;
  const calib::Solution solution = solution_of(world);
  EXPECT_THAT(all_in_words(solution), IsEmpty());
  EXPECT_THAT(solution.warnings, Contains(HasSubstr("beacon B5")));
  EXPECT_LT(worst_beacon_m(world, solution), 0.02);
}

TEST(Agreement, ABeaconThatIsLateAtHalfOfTheStopsIsWhereItsDirectArrivalsHaveIt) {
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    for (const std::size_t beacon : {1U, 4U, 5U}) {
      World world = must(simulate(sixty_stops(), seed));
      for (Arrival& a : world.run.arrivals)
        if (a.beacon.index() == beacon && (a.epoch + static_cast<std::int64_t>(seed)) % 9 < 4)
          a.tof_s += 0.3 / 343;
      const calib::Solution solution = solution_of(world);
      if (worst_beacon_m(world, solution) < 0.03) {
        ++right;
        continue;
      }
      // Where more of its late arrivals agree on a place than of the direct ones, these are early there.
      EXPECT_EQ(only(solution).subject, "B" + std::to_string(beacon)) << "seed " << seed;
    }
  EXPECT_GE(right, 23) << "of 24";
}

/// Stops all over the hall, and the same number next to each other.
World with_stops_beside_each_other(std::uint64_t seed) {
  Scenario s = hall_scenario();
  s.hearing_half_angle_rad = 3.2;
  s.path.kind = PathKind::kStations;
  s.path.epochs = 60;
  for (int k = 0; k < 30; ++k)
    s.path.stations.emplace_back(3.0 + 0.45 * k, 6.0 + 4.0 * std::sin(0.7 * k), 0.5 * k);
  for (int k = 0; k < 30; ++k) s.path.stations.emplace_back(5.0 + 0.001 * k, 5.0, 1.0);
  return must(simulate(s, seed));
}

TEST(Agreement, EarlyArrivalsAllOverTheHallContradict) {
  World world = with_stops_beside_each_other(17);
  const std::int64_t first = world.run.arrivals.front().epoch;
  for (Arrival& a : world.run.arrivals)
    if (a.beacon.index() == 5 && (a.epoch - first) % 3 == 0) a.tof_s -= 0.3 / 343;
  const Contradiction c = only(solution_of(world));
  EXPECT_EQ(c.subject, "B5");
  EXPECT_THAT(c.found, HasSubstr("early"));
}

// An obstacle or an echo affects a place and a beacon; if all places and beacons are affected, the receiver
// is the cause.
TEST(Agreement, AReceiverMostOfWhoseArrivalsAreLeftOutContradicts) {
  for (const bool all_over : {true, false}) {
    World world = must(simulate(sixty_stops(), 5));
    const std::int64_t first = world.run.arrivals.front().epoch;
    for (Arrival& a : world.run.arrivals)
      if (a.receiver.index() == 2 && (all_over ? (a.epoch - first) % 4 != 0 : (a.epoch - first) % 4 == 0))
        a.tof_s += (1.0 + 0.1 * static_cast<double>((a.epoch + a.beacon.index()) % 7)) / 343;
    const calib::Solution solution = solution_of(world);
    if (!all_over) {
      EXPECT_THAT(solution.contradictions, IsEmpty()) << all_in_words(solution);
      continue;
    }
    const Contradiction c = only(solution);
    EXPECT_EQ(c.kind, ContradictionKind::kReceiver);
    EXPECT_EQ(c.subject, "robot/r2");
    EXPECT_THAT(c.found, HasSubstr("late"));
  }
}

// Common errors of one place (a reflection, a camera's view) are one event, however often it is recorded.
TEST(Agreement, EarlyArrivalsOfOnePlaceAreNamedAndContradictNothing) {
  World world = with_stops_beside_each_other(18);
  const std::int64_t first = world.run.arrivals.front().epoch;
  for (Arrival& a : world.run.arrivals)
    if (a.beacon.index() == 5 && a.epoch - first >= 48) a.tof_s -= 0.3 / 343;
  const calib::Solution solution = solution_of(world);
  EXPECT_THAT(all_in_words(solution), IsEmpty());
  EXPECT_THAT(solution.warnings, Contains(HasSubstr("beacon B5")));
  EXPECT_LT(worst_beacon_m(world, solution), 0.02);
}

}  // namespace statements_test
}  // namespace octant::test
