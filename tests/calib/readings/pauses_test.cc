// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pauses.h"

#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace pauses_test {

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

}  // namespace pauses_test
}  // namespace octant::test
