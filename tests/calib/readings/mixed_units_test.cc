// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/mixed_units.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace mixed_units_test {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;

const calib::LengthUnit kFeet{"feet", 0.3048};

TEST(MixedUnits, ARightSiteHasNone) {
  const World world = cart(), drive = must(simulate(drive_scenario(), 5));
  for (const calib::LengthUnit& unit : calib::length_units()) {
    EXPECT_THAT(calib::beacons_in_unit_by_ranges(world.site, {world.run}, unit), IsEmpty());
    EXPECT_THAT(calib::beacons_in_unit_by_ranges(drive.site, {drive.run}, unit), IsEmpty());
  }
}

TEST(MixedUnits, TellAnyShareOfTheBeaconsApart) {
  for (const unsigned share : {0b00000100U, 0b01010101U, 0b11101110U}) {
    for (World world : {cart(), must(simulate(drive_scenario(), 5))}) {
      std::vector<bool> in_feet(world.site.beacons.size());
      for (std::size_t b = 0; b < in_feet.size(); ++b) {
        in_feet[b] = (share >> b & 1U) != 0;
        for (auto& x : world.site.beacons[b].position_m)
          if (in_feet[b]) *x /= kFeet.metres;
      }
      EXPECT_THAT(calib::beacons_in_unit_by_ranges(world.site, {world.run}, kFeet), Contains(in_feet))
          << share;
    }
  }
}

// There is a separate hypothesis for that.
TEST(MixedUnits, AllInOneUnitAreNotMixed) {
  World world = cart();
  for (SiteBeacon& b : world.site.beacons)
    for (auto& x : b.position_m) *x /= kFeet.metres;
  const std::vector<bool> all(world.site.beacons.size(), true);
  EXPECT_THAT(calib::beacons_in_unit_by_ranges(world.site, {world.run}, kFeet), Not(Contains(all)));
}

TEST(MixedUnits, WithoutRangesNothingIsTold) {
  World world = cart();
  for (auto& x : world.site.beacons[2].position_m) *x /= kFeet.metres;
  world.run.arrivals.clear();
  EXPECT_THAT(calib::beacons_in_unit_by_ranges(world.site, {world.run}, kFeet), IsEmpty());
}

}  // namespace mixed_units_test
}  // namespace octant::test
