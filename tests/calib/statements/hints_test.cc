// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/hints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace hints_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

}  // namespace hints_test
}  // namespace octant::test
