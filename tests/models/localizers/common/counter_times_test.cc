// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/counter_times.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace octant {
namespace counter_times_test {

TEST(CounterTimes, OneTickOf20MhzIs50Nanoseconds) {
  EXPECT_DOUBLE_EQ(counter_time_s(1), 50e-9);  // eq. 1; the paper prints 0.000000005
  EXPECT_DOUBLE_EQ(counter_time_s(400'000), 0.02);
}

TEST(CounterTimes, MeanOfFourLeavesTheOddOneOut) {
  const std::array<double, 4> all = {10.0, 10.2, 9.9, 10.1};
  EXPECT_DOUBLE_EQ(mean_of_agreeing(all, 1.0).mean, 10.05);  // eq. 2
  const std::array<double, 4> echo = {10.0, 14.0, 9.9, 10.1};
  const AgreeingMean three = mean_of_agreeing(echo, 1.0);
  EXPECT_EQ(three.agreeing, 3u);
  EXPECT_DOUBLE_EQ(three.mean, 10.0);
  const std::array<double, 4> tie = {14.0, 10.0, 14.1, 10.1};
  EXPECT_DOUBLE_EQ(mean_of_agreeing(tie, 1.0).mean, 10.05)
      << "of two against two the earlier: echoes are late";
  const std::array<double, 1> one = {3.0};
  EXPECT_DOUBLE_EQ(mean_of_agreeing(one, 0.0).mean, 3.0);
}

}  // namespace counter_times_test
}  // namespace octant
