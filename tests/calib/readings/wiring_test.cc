// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/wiring.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace wiring_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

}  // namespace wiring_test
}  // namespace octant::test
