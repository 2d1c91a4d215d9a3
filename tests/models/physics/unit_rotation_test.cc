// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/unit_rotation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace octant {
namespace unit_rotation_test {

TEST(UnitRotation, IsTheSameForAQuaternionOfAnyLength) {
  const double half = 0.35;
  for (const double length : {1.0, 0.01, 250.0}) {
    const auto rotation = unit_rotation(0.0, 0.0, length * std::sin(half), length * std::cos(half));
    ASSERT_TRUE(rotation.has_value());
    EXPECT_NEAR(rotation->norm(), 1.0, 1e-15);
    EXPECT_NEAR(rotation->angularDistance(Eigen::Quaterniond::Identity()), 2 * half, 1e-12);
    EXPECT_GT(rotation->z(), 0.0);
  }
}

TEST(UnitRotation, NoLengthOrNoNumbersIsNone) {
  EXPECT_FALSE(unit_rotation(0.0, 0.0, 0.0, 0.0));
  EXPECT_FALSE(unit_rotation(0.0, 1e-4, 0.0, 0.0));
  EXPECT_FALSE(unit_rotation(0.0, 0.0, 0.0, NAN));
  EXPECT_FALSE(unit_rotation(INFINITY, 0.0, 0.0, 1.0));
}

}  // namespace unit_rotation_test
}  // namespace octant
