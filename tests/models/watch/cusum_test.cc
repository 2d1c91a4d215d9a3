// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/cusum.h"

#include <gtest/gtest.h>

#include "models/simulator/random.h"

namespace octant {
namespace cusum_test {

TEST(Cusum, ASumBeginsAnewAtZero) {
  CumulativeSum sum;
  EXPECT_FALSE(sum.add(-3.0));
  EXPECT_EQ(sum.value, 0.0) << "what spoke against a change is not saved up";
  EXPECT_TRUE(sum.add(2.0));
  EXPECT_TRUE(sum.add(-1.5));
  EXPECT_EQ(sum.value, 0.5);
  EXPECT_FALSE(sum.add(-0.5));
}

TEST(Cusum, RunLengthsAreThoseOfTheTables) {
  // Two-sided, k = 0.5: h 4 168, h 5 465 (D. C. Montgomery, Introduction to Statistical Quality Control,
  // table 9.3).
  EXPECT_NEAR(run_length(0.5, 4.0), 168.0, 0.03 * 168.0);
  EXPECT_NEAR(run_length(0.5, 5.0), 465.0, 0.03 * 465.0);
  EXPECT_NEAR(cusum_threshold(0.5, 465.0), 5.0, 0.02);
}

// The run length by simulation, independent of the formula.
TEST(Cusum, FalseAlarmsComeAsOftenAsStated) {
  Random draws(1);
  const double stated = 200.0, h = cusum_threshold(0.5, stated);
  double values = 0.0;
  const int alarms = 4000;
  for (int i = 0; i < alarms; ++i)
    for (Cusum cusum{0.5, h}; cusum.alarm() == 0; ++values) cusum.add(draws.normal());
  // Run lengths are spread like an exponential: 4,000 of them give their mean to 1.6 %, and the formula is
  // good to 3 %.
  EXPECT_NEAR(values / alarms, stated, stated * (0.03 + 4 * 0.016));
}

}  // namespace cusum_test
}  // namespace octant
