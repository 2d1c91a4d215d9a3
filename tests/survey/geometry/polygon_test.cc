// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/polygon.h"

#include <gtest/gtest.h>

namespace octant::survey {
namespace {

TEST(Polygon, SelfCrossing) {
  EXPECT_FALSE(self_crossing({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}, {0, 2}}));
  EXPECT_TRUE(self_crossing({{0, 0}, {2, 0}, {2, 2}, {1, -0.5}, {0, 2}}));
  EXPECT_TRUE(self_crossing({{0, 0}, {2, 2}, {2, 0}, {0, 2}}));
  EXPECT_TRUE(self_crossing({{0, 0}, {2, 0}, {1, 0}, {1, 2}}));          // folds back
  EXPECT_TRUE(self_crossing({{0, 0}, {4, 0}, {4, 2}, {2, 0}, {0, 2}}));  // touches its own side
}

}  // namespace
}  // namespace octant::survey
