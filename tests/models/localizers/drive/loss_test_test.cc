// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/loss_test.h"

#include <random>

#include <gtest/gtest.h>

namespace octant {
namespace loss_test_test {

/// A ping of four arrivals.
void ping(LossTest& test, int k, bool fits) {
  for (int i = 0; i < 4; ++i) test.add(BeaconId(static_cast<std::size_t>(k % 5)), 0.1 * k + 1e-3 * i, fits);
}

TEST(LossTest, SixPingsThatDoNotFitAreALoss) {
  LossTest test;
  EXPECT_TRUE(test.is_calm());
  for (int k = 0; k < 6; ++k) {
    EXPECT_FALSE(test.is_lost()) << k;
    ping(test, k, false);
    EXPECT_FALSE(test.is_calm());
  }
  EXPECT_TRUE(test.is_lost());
}

TEST(LossTest, AnEchoThatReachesAllReceiversCountsOnce) {
  LossTest test;
  for (int i = 0; i < 8; ++i) test.add(BeaconId(std::size_t{1}), 1e-3 * i, false);
  EXPECT_FALSE(test.is_lost());
  ping(test, 2, true);
  EXPECT_TRUE(test.is_calm());
}

TEST(LossTest, TheLastVerdictOnAPingCounts) {
  LossTest test;
  for (int k = 0; k < 20; ++k) {  // an echo at the first receiver, a direct arrival at the second one
    test.add(BeaconId(std::size_t{1}), 0.1 * k, false);
    test.add(BeaconId(std::size_t{1}), 0.1 * k + 1e-3, true);
    EXPECT_TRUE(test.is_calm());
  }
}

TEST(LossTest, OneEchoInTenIsNoLoss) {
  std::mt19937_64 random(5);
  LossTest test;
  int lost = 0;
  for (int k = 0; k < 100'000; ++k) {
    ping(test, k, random() % 10 != 0);
    lost += test.is_lost();
    if (test.is_lost()) test.clear();
  }
  EXPECT_LE(lost, 2);
}

}  // namespace loss_test_test
}  // namespace octant
