// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/beacon_bank.h"

#include <gtest/gtest.h>

#include "models/localizers/drive/tracker.h"
#include "tests/models/localizers/off_truth.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

// A beacon whose times creep off by 20 us a second, which no arrival by itself shows: the filter follows it,
// the one without it does not.
TEST(BeaconBank, ACreepingBeaconStaysWithinTheLevel) {
  World world = must(simulate(drive_scenario(60.0), 7));
  for (Arrival& a : world.heldout.arrivals)
    if (a.beacon == BeaconId(2))
      a.tof_s += 20e-6 * std::max(0.0, a.time_s - world.heldout.arrivals.front().time_s - 15.0);
  int leveled = 0, beyond = 0, of_others = 0;
  TrackerOptions options;
  options.protect = true;
  options.smooth = false;
  std::size_t row = 0;
  for (const Fix& fix : track(world.heldout, world.truth, options)) {
    for (const Rejection r : fix.rejections) {
      const bool out = r == Rejection::kBeaconFault;
      of_others += out && world.heldout.arrivals[row].beacon != BeaconId(2);
      ++row;
    }
    if (!fix.ok() || fix.protection_level_m == 0.0) continue;
    ++leveled;
    beyond += off_truth_m(world, fix) > fix.protection_level_m;
  }
  EXPECT_GT(leveled, 500);
  EXPECT_EQ(beyond, 0);
  EXPECT_EQ(of_others, 0);
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

}  // namespace
}  // namespace octant::test
