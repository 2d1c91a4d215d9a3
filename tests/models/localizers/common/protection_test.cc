// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/protection.h"

#include <map>

#include <gtest/gtest.h>

#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

double off_m(const World& world, const Fix& fix) {
  Pose truth;
  EXPECT_TRUE(interpolate_poses(world.heldout.truth, fix.time_s, 1.0, truth));
  return (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>().norm();
}

Scenario many_stops() {
  Scenario s = hall_scenario();
  s.path.epochs = 1;
  s.heldout_path.epochs = 300;
  return s;
}

TEST(Protection, HoldsWithoutFaultsAndIsMoreThanNoise) {
  const World world = must(simulate(many_stops(), 1));
  int protected_fixes = 0;
  for (const Fix& fix : LeastSquaresLocalizer(world.truth).locate(world.heldout)) {
    if (!fix.ok() || fix.protection_level_m == 0.0) continue;
    ++protected_fixes;
    EXPECT_LT(off_m(world, fix), fix.protection_level_m);
    EXPECT_GT(fix.protection_level_m, 3.29 * std::sqrt(std::max(fix.covariance(0, 0), fix.covariance(1, 1))));
  }
  EXPECT_GT(protected_fixes, 250);
}

// One beacon of each epoch late by 30 us, 10 mm: below what an epoch would notice, and the level still holds.
TEST(Protection, HoldsWithOneBeaconAtFault) {
  World world = must(simulate(many_stops(), 2));
  std::map<std::int64_t, BeaconId> faulty;
  for (Arrival& a : world.heldout.arrivals) {
    const auto [it, added] = faulty.try_emplace(a.epoch, a.beacon);
    if (it->second == a.beacon) a.tof_s += 30e-6;
  }
  int beyond = 0, count = 0;
  for (const Fix& fix : LeastSquaresLocalizer(world.truth).locate(world.heldout)) {
    if (!fix.ok() || fix.protection_level_m == 0.0) continue;
    ++count;
    beyond += off_m(world, fix) > fix.protection_level_m;
  }
  ASSERT_GT(count, 200);
  EXPECT_LE(beyond, 1);  // one in a thousand by construction
}

TEST(Protection, TwoBeaconsCannotWatchEachOther) {
  World world = must(simulate(many_stops(), 3));
  std::erase_if(world.heldout.arrivals, [](const Arrival& a) { return a.beacon.value > 1; });
  // The heading alone connects them, over an array of 65 mm: metres, or none at all.
  for (const Fix& fix : LeastSquaresLocalizer(world.truth).locate(world.heldout))
    EXPECT_TRUE(fix.protection_level_m == 0.0 || fix.protection_level_m > 0.5)
        << fix.epoch << " " << fix.protection_level_m;
}

}  // namespace
}  // namespace octant::test
