// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/site_units.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace site_units_test {

using ::testing::HasSubstr;

TEST(SiteUnits, OfBeaconsThatAloneAreInCentimetres) {
  World world = cart();
  for (const std::size_t b : {1U, 3U})
    for (auto& x : world.site.beacons[b].position_m) *x *= 100;
  const auto some = calib::beacons_in_unit(world.site, calib::length_units()[0]);
  EXPECT_EQ(std::count(some.begin(), some.end(), true), 2);
  EXPECT_TRUE(some[1] && some[3]);
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

}  // namespace site_units_test
}  // namespace octant::test
