// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/heard.h"

#include <gtest/gtest.h>

namespace octant::test {
namespace heard_test {

/// Receivers at 0.4 m; one beacon above them, one below, one with a fixed height.
Deployment three_beacons() {
  Deployment d;
  d.motion = Motion::kPlanar;
  for (const double z_m : {0.3, 0.5}) d.receivers.emplace_back().position_m = {0.0, 0.1, z_m};
  for (const double z_m : {2.5, 0.1, 3.0}) d.beacons.emplace_back().position_m = {1.0, 2.0, z_m};
  return d;
}

TEST(Heard, BeaconsAreTurnedToTheSideOfTheReceiversThatIsKnown) {
  Deployment d = three_beacons();
  calib::ParameterLayout layout;
  layout.beacon = {{0, 1, 2}, {3, 4, 5}, {-1, -1, -1}};
  Eigen::VectorXd x(6);
  x << 1.0, 2.0, -1.7, 1.0, 2.0, 0.2;
  EXPECT_TRUE(calib::turn_to_known_side(d, layout, x));
  EXPECT_DOUBLE_EQ(x[2], 2.5);
  EXPECT_DOUBLE_EQ(x[5], 0.2);
  EXPECT_FALSE(calib::turn_to_known_side(d, layout, x));
  x[2] = -1.7;
  d.motion = Motion::kSpatial;
  EXPECT_FALSE(calib::turn_to_known_side(d, layout, x));
  EXPECT_DOUBLE_EQ(x[2], -1.7);
}

}  // namespace heard_test
}  // namespace octant::test
