// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/polygon.h"

#include <gtest/gtest.h>

namespace octant {
namespace polygon_test {

TEST(Polygon, SelfCrossing) {
  EXPECT_FALSE(self_crossing({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}, {0, 2}}));
  EXPECT_TRUE(self_crossing({{0, 0}, {2, 0}, {2, 2}, {1, -0.5}, {0, 2}}));
  EXPECT_TRUE(self_crossing({{0, 0}, {2, 2}, {2, 0}, {0, 2}}));
  EXPECT_TRUE(self_crossing({{0, 0}, {2, 0}, {1, 0}, {1, 2}}));          // folds back
  EXPECT_TRUE(self_crossing({{0, 0}, {4, 0}, {4, 2}, {2, 0}, {0, 2}}));  // touches its own side
}

TEST(Polygon, HullIsThatOfTheCornersCounterClockwise) {
  const Polygon hull = convex_hull({{1, 1}, {0, 0}, {4, 0}, {2, 0}, {4, 3}, {0, 3}, {2, 2}, {4, 3}});
  EXPECT_EQ(hull, (Polygon{{0, 0}, {4, 0}, {4, 3}, {0, 3}}));
  EXPECT_DOUBLE_EQ(signed_area_m2(hull), 12.0);
  EXPECT_EQ(convex_hull({{2, 0}, {1, 5}}), (Polygon{{1, 5}, {2, 0}})) << "too few for an area: as they are";
}

TEST(Polygon, NearestOnTheOutlineAndBounds) {
  const Polygon square = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  EXPECT_EQ(nearest_on_outline(square, {3, 1.5}), Eigen::Vector2d(4, 1.5));
  EXPECT_EQ(nearest_on_outline(square, {-3, -4}), Eigen::Vector2d(0, 0));
  EXPECT_DOUBLE_EQ(distance_to_outline_m(square, {-3, -4}), 5.0);
  EXPECT_EQ(bounds_of(square).sizes(), Eigen::Vector2d(4, 4));
  EXPECT_TRUE(bounds_of({}).isEmpty());
}

}  // namespace polygon_test
}  // namespace octant
