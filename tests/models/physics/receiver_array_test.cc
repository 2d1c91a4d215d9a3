// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/receiver_array.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/golden.h"

namespace octant {
namespace receiver_array_test {

TEST(Octagon, RadiusHasThePrintedDigits) {
  for (const auto& c : test::golden_cases("octagon")) {
    EXPECT_NEAR(octagon_radius_m(c["side_m"]), c["radius_m"].get<double>(), c["half_digit_m"].get<double>())
        << c;
  }
}

TEST(Octagon, NeighboursAreOneSideApart) {
  const auto corners = octagon(0.05, 0.3);
  ASSERT_EQ(corners.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR((corners[i].position_m - corners[(i + 1) % 8].position_m).norm(), 0.05, 1e-16);
    EXPECT_EQ(corners[i].position_m.z(), 0.3);
  }
}

TEST(Octagon, FirstIsAheadAndTheRestCounterClockwise) {
  const auto corners = octagon(0.05, 0.3);
  EXPECT_EQ(corners[0].position_m, Eigen::Vector3d(octagon_radius_m(0.05), 0.0, 0.3));
  for (std::size_t i = 0; i < 8; ++i) {
    const double angle = std::atan2(corners[i].position_m.y(), corners[i].position_m.x());
    EXPECT_NEAR(std::remainder(angle - static_cast<double>(i) * M_PI / 4, 2 * M_PI), 0.0, 1e-15);
  }
}

TEST(Octagon, HearsOutwards) {
  for (const ArrayElement& corner : octagon(0.05, 0.3, 0.2)) {
    EXPECT_NEAR(corner.axis.norm(), 1.0, 1e-15);
    EXPECT_EQ(corner.axis.z(), 0.0);
    EXPECT_NEAR(corner.axis.dot(corner.position_m), octagon_radius_m(0.05), 1e-16);
  }
}

TEST(Octagon, TurnTurnsAll) {
  const auto straight = octagon(0.05, 0.3), turned = octagon(0.05, 0.3, M_PI / 4);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_TRUE(turned[i].position_m.isApprox(straight[(i + 1) % 8].position_m, 1e-14));
}

}  // namespace receiver_array_test
}  // namespace octant
