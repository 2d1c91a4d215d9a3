// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/beacon_bank.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "models/localizers/drive/tracker.h"
#include "tests/models/localizers/off_truth.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace beacon_bank_test {

/// The hall with beacons at all heights, flown through.
Scenario flight_among_all_heights(double duration_s) {
  constexpr double kHeights[] = {2.5, 0.5, 2.6, 1.3, 3.4, 0.6, 2.4, 1.5};
  Scenario s = drive_scenario(duration_s);
  s.site.motion = Motion::kSpatial;
  s.hearing_half_angle_rad = 3.2;
  s.log_odometry = true;
  s.odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.02, .heading_sigma_rad_per_sqrt_m = 0.02};
  for (std::size_t i = 0; i < s.site.beacons.size(); ++i) s.site.beacons[i].position_m[2] = kHeights[i];
  return s;
}

struct Levels {
  int given = 0, beyond = 0, faults = 0, faults_of_others = 0;
  double largest_m = 0.0;
};

bool is_of(const Arrival& a, BeaconId beacon) { return a.beacon == beacon; }
bool is_of(const Arrival& a, ReceiverId receiver) { return a.receiver == receiver; }

/// Levels of the causal filter. The times of a beacon or a receiver are off by a function of the time since
/// the start.
template <class Member, class Fault>
Levels levels_with(World world, Member at_fault, Fault&& late_s) {
  for (Arrival& a : world.heldout.arrivals)
    if (is_of(a, at_fault)) a.tof_s += late_s(a.time_s - world.heldout.arrivals.front().time_s);
  Levels levels;
  TrackerOptions options;
  options.protect = true;
  options.smooth = false;
  std::size_t row = 0;
  for (const Fix& fix : track(world.heldout, world.truth, options)) {
    for (const Rejection r : fix.rejections) {
      const bool of_it = is_of(world.heldout.arrivals[row++], at_fault);
      if (r == Rejection::kBeaconFault) ++(of_it ? levels.faults : levels.faults_of_others);
    }
    if (!fix.ok() || fix.protection_level_m == 0.0) continue;
    ++levels.given;
    levels.beyond += off_truth_m(world, fix) > fix.protection_level_m;
    levels.largest_m = std::max(levels.largest_m, fix.protection_level_m);
  }
  return levels;
}

// A beacon whose times drift by 20 us a second, which no single arrival shows: the filter follows it, the one
// without it does not.
double creeping_s(double time_s) { return 20e-6 * std::max(0.0, time_s - 15.0); }

TEST(BeaconBank, ACreepingBeaconStaysWithinTheLevel) {
  const Levels levels = levels_with(must(simulate(drive_scenario(60.0), 7)), BeaconId(2), creeping_s);
  EXPECT_GT(levels.given, 500);
  EXPECT_EQ(levels.beyond, 0);
  EXPECT_EQ(levels.faults_of_others, 0);
  EXPECT_LT(levels.largest_m, 1.0) << "filters begin again with what is known of the pose";
}

// One of three receivers, whose times creep off by 2 us a second: too slow for an arrival to be rejected at
// first. All filters with its arrivals deviate, but only the one without it fits.
TEST(BeaconBank, ACreepingReceiverStaysWithinTheLevelAndNoOtherIsBlamed) {
  Scenario scenario = drive_scenario(60.0);
  scenario.site.receivers.clear();
  scenario.site.vehicles.clear();
  add_receivers(scenario.site, {{0.25, 0.0, 0.3}, {-0.15, 0.2, 0.3}, {-0.15, -0.2, 0.3}});
  for (const std::uint64_t seed : {7, 8, 9}) {
    const Levels levels = levels_with(must(simulate(scenario, seed)), ReceiverId(1),
                                      [](double time_s) { return 2e-6 * std::max(0.0, time_s - 15.0); });
    EXPECT_GT(levels.given, 2000) << seed;
    EXPECT_EQ(levels.beyond, 0) << seed;
    EXPECT_EQ(levels.faults_of_others, 0) << seed;
    EXPECT_LT(levels.largest_m, 0.2) << seed;
  }
}

TEST(BeaconBank, ABeaconThatWasOffBeforeTheStartStaysWithinTheLevel) {
  for (const double late_s : {60e-6, 200e-6, 1e-3})
    for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
      const Levels levels = levels_with(must(simulate(drive_scenario(30.0), seed)), BeaconId(seed % 8),
                                        [late_s](double) { return late_s; });
      EXPECT_GT(levels.given, 500) << seed;
      EXPECT_EQ(levels.beyond, 0) << seed << " " << late_s;
      EXPECT_LT(levels.largest_m, 1.0) << seed << " " << late_s;
    }
}

TEST(BeaconBank, ACreepingBeaconStaysWithinTheLevelInSpace) {
  int given = 0, faults = 0;
  for (const std::uint64_t seed : {1, 2, 4}) {
    const Levels levels =
        levels_with(must(simulate(flight_among_all_heights(60.0), seed)), BeaconId(seed), creeping_s);
    EXPECT_EQ(levels.beyond, 0) << seed;
    EXPECT_LT(levels.largest_m, 1.0) << seed;
    given += levels.given;
    faults += levels.faults;
  }
  EXPECT_GT(given, 15000);
  EXPECT_GT(faults, 500) << "and is found";
}

TEST(BeaconBank, ABeaconThatWasOffBeforeTheStartStaysWithinTheLevelInSpace) {
  int given = 0;
  for (const std::uint64_t seed : {1, 4, 8}) {
    const Levels levels = levels_with(must(simulate(flight_among_all_heights(30.0), seed)),
                                      BeaconId(seed % 8), [](double) { return 200e-6; });
    EXPECT_EQ(levels.beyond, 0) << seed;
    given += levels.given;
  }
  EXPECT_GT(given, 6000);  // arrivals of the beacon that is left out give no fix
}

TEST(BeaconBank, BlamesNoGoodBeaconInSpace) {
  for (const std::uint64_t seed : {3, 5}) {
    const Levels levels = levels_with(must(simulate(flight_among_all_heights(30.0), seed)), BeaconId(0),
                                      [](double) { return 0.0; });
    EXPECT_GT(levels.given, 2000) << seed;
    EXPECT_EQ(levels.beyond + levels.faults + levels.faults_of_others, 0) << seed;
    EXPECT_LT(levels.largest_m, 0.3) << seed;
  }
}

/// This hall with some of its beacons, received everywhere.
World flight_among(const std::vector<std::size_t>& beacons, std::uint64_t seed) {
  Scenario s = flight_among_all_heights(30.0);
  std::vector<SiteBeacon> some;
  for (const std::size_t b : beacons) some.push_back(s.site.beacons[b]);
  s.site.beacons = some;
  s.range_m = 25.0;
  return must(simulate(s, seed));
}

TEST(BeaconBank, WithoutOneOfThreeBeaconsInSpaceNothingIsSaid) {
  for (const std::uint64_t seed : {5, 6}) {
    const Levels levels = levels_with(flight_among({0, 3, 4}, seed), BeaconId(0), [](double) { return 0.0; });
    EXPECT_EQ(levels.given + levels.faults + levels.faults_of_others, 0) << seed;
  }
}

TEST(BeaconBank, WhereThreeAreLeftInSpaceNothingIsSaid) {
  Scenario s = flight_among_all_heights(60.0);
  s.range_m = 25.0;
  World world = must(simulate(s, 4));
  const double until_s = world.heldout.arrivals.front().time_s + 8.0;
  std::erase_if(world.heldout.arrivals, [until_s](const Arrival& a) {
    return a.time_s > until_s && a.beacon != BeaconId(0) && a.beacon != BeaconId(3) &&
           a.beacon != BeaconId(4);
  });
  const Levels levels = levels_with(std::move(world), BeaconId(0), [](double) { return 0.0; });
  EXPECT_GT(levels.given, 500) << "while all are heard";
  EXPECT_LT(levels.given, 1500);
  EXPECT_EQ(levels.beyond + levels.faults + levels.faults_of_others, 0);
}

TEST(BeaconBank, OfFourBeaconsInSpaceAFaultTakesTheLevelAndNoneIsBlamed) {
  for (const std::uint64_t seed : {1, 4}) {
    const Levels levels = levels_with(flight_among({0, 3, 4, 6}, seed), BeaconId(1), creeping_s);
    EXPECT_GT(levels.given, 2000) << seed;
    EXPECT_EQ(levels.beyond + levels.faults + levels.faults_of_others, 0) << seed;
    EXPECT_GT(levels.largest_m, 0.15) << seed;
  }
}

TEST(BeaconBank, NoneIsWantedNoneIsGiven) {
  const World world = must(simulate(drive_scenario(20.0), 8));
  TrackerOptions options;
  options.smooth = options.protect = false;
  const auto without = track(world.heldout, world.truth, options);
  options.protect = true;
  const auto with = track(world.heldout, world.truth, options);
  ASSERT_EQ(with.size(), without.size());
  int leveled = 0;
  for (std::size_t i = 0; i < with.size(); ++i) {
    EXPECT_EQ(without[i].protection_level_m, 0.0);
    EXPECT_EQ(integrity(without[i]), without[i].ok() ? Integrity::kDegraded : Integrity::kNoFix);
    EXPECT_EQ(with[i].T_map_vehicle.translation_m, without[i].T_map_vehicle.translation_m)
        << "levels change no fix";
    leveled += with[i].protection_level_m > 0.0;
  }
  EXPECT_GT(leveled, 100);
}

}  // namespace beacon_bank_test
}  // namespace octant::test
