// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain/chain_protection.h"

#include <map>

#include <gtest/gtest.h>

#include "models/localizers/common/protection.h"
#include "models/localizers/drive/tracker.h"
#include "tests/models/localizers/off_truth.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace chain_protection_test {

constexpr TrackerOptions kProtected{.protect = true};

double horizontal_sigma_m(const Fix& fix) { return std::sqrt(horizontal_variance(fix.covariance)); }

// Comparison with complete solutions: the drive is localized again with far echoes only from one beacon after
// the other.
TEST(ChainProtection, IsTheFarthestOfTheDrivesWithoutABeacon) {
  World world = must(simulate(drive_scenario(40.0), 5));
  for (Arrival& a : world.heldout.arrivals)
    if (a.beacon == BeaconId(2)) a.tof_s += 20e-6;  // two sigmas: in use, and shifts are more than noise
  const std::vector<Fix> all = track(world.heldout, world.truth, kProtected);
  std::map<double, double> expected_m;  // by time
  for (const Fix& fix : all) expected_m[fix.time_s] = kFaultFreeSigmas * horizontal_sigma_m(fix);
  std::map<double, Fix> by_time;
  for (const Fix& fix : all) by_time.emplace(fix.time_s, fix);
  for (std::size_t b = 0; b < world.truth.beacons.size(); ++b) {
    MeasurementLog log = world.heldout;
    for (Arrival& a : log.arrivals)
      if (a.beacon.index() == b) a.tof_s += 0.02;
    for (const Fix& fix : track(log, world.truth)) {
      const auto with = by_time.find(fix.time_s);
      if (with == by_time.end()) continue;
      ASSERT_TRUE(fix.ok());
      const double shift_m =
          (fix.T_map_vehicle.translation_m - with->second.T_map_vehicle.translation_m).head<2>().norm();
      double& worst_m = expected_m[fix.time_s];
      worst_m = std::max(worst_m, shift_m + kFaultySigmas * horizontal_sigma_m(fix));
    }
  }
  int leveled = 0;
  for (const Fix& fix : all) {
    if (fix.protection_level_m == 0.0) continue;
    ++leveled;
    // Linear instead of solved again, over shifts of millimetres.
    EXPECT_NEAR(fix.protection_level_m, expected_m[fix.time_s], 0.005 * expected_m[fix.time_s]) << fix.time_s;
  }
  EXPECT_GT(leveled, 1000);
}

TEST(ChainProtection, ACreepingBeaconStaysWithinTheLevel) {
  for (const double creep_s : {0.0, 1e-6, 2e-6, 20e-6}) {
    World world = must(simulate(drive_scenario(60.0), 7));
    const double start_s = world.heldout.arrivals.front().time_s + 15.0;
    for (Arrival& a : world.heldout.arrivals)
      if (a.beacon == BeaconId(2)) a.tof_s += creep_s * std::max(0.0, a.time_s - start_s);
    int leveled = 0, beyond = 0;
    for (const Fix& fix : track(world.heldout, world.truth, kProtected)) {
      if (!fix.ok() || fix.protection_level_m == 0.0) continue;
      ++leveled;
      beyond += off_truth_m(world, fix) > fix.protection_level_m;
    }
    EXPECT_EQ(beyond, 0) << creep_s;
    EXPECT_GT(leveled, 1000) << creep_s;
  }
}

TEST(ChainProtection, ChangesNoFixAndIsNotThereUnasked) {
  const World world = must(simulate(drive_scenario(20.0), 8));
  const std::vector<Fix> plain = track(world.heldout, world.truth),
                         bounded = track(world.heldout, world.truth, kProtected);
  ASSERT_EQ(plain.size(), bounded.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(plain[i].T_map_vehicle.translation_m, bounded[i].T_map_vehicle.translation_m);
    EXPECT_EQ(plain[i].rejections, bounded[i].rejections);
    EXPECT_EQ(plain[i].protection_level_m, 0.0);
  }
}

// A single beacon determines a drive along its path by odometry; without odometry it does not.
TEST(ChainProtection, NoLevelWhereADriveHangsOnOneBeacon) {
  World world = must(simulate(drive_scenario(60.0), 9));
  std::erase_if(world.heldout.arrivals, [](const Arrival& a) { return a.beacon.value != 1; });
  for (const Fix& fix : track(world.heldout, world.truth, kProtected)) EXPECT_EQ(fix.protection_level_m, 0.0);
}

}  // namespace chain_protection_test
}  // namespace octant::test
