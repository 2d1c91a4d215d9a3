// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/reading.h"

#include <cmath>

#include <gtest/gtest.h>

namespace octant::test {
namespace reading_test {

TEST(LikeliestSize, IsFoundToAPartInAHundred) {
  for (const double size : {0.013, -0.031, 0.2, -0.7, 1.9}) {
    int asked = 0;
    // Range errors of a speed times the remaining lag, with noise: the logarithm of their scatter.
    const auto loss = [size](double tried) { return std::log(std::hypot(0.004, 0.5 * (tried - size))); };
    const auto found = calib::likeliest_size(0.02, 2.0, loss(0.0), [&](double tried) {
      ++asked;
      return loss(tried);
    });
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(*found, size, 0.01 * std::abs(size));
    EXPECT_LE(asked, 30);
  }
}

TEST(LikeliestSize, IsNotRefinedWhereNoSizeExplainsMore) {
  int asked = 0;
  EXPECT_FALSE(calib::likeliest_size(0.02, 2.0, 0.0, [&](double tried) {
                 ++asked;
                 return tried * tried;
               }).has_value());
  EXPECT_LE(asked, 14);
}

}  // namespace reading_test
}  // namespace octant::test
