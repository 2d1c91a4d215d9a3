// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_clock.h"

#include <gtest/gtest.h>

namespace octant::test {
namespace {

/// A vehicle that goes straight on, ten poses a second and as many arrivals.
MeasurementLog straight_on(double speed_mps) {
  MeasurementLog run;
  for (int i = 0; i < 50; ++i) {
    run.poses.push_back({0.1 * i, Pose::planar(speed_mps * 0.1 * i, 1.0, 0.0)});
    run.arrivals.push_back({});
    run.arrivals.back().time_s = 0.1 * i;
  }
  return run;
}

TEST(PoseClock, MattersWhereTheVehicleMovesWhileItIsMeasured) {
  EXPECT_FALSE(calib::poses_are_of_motion({}));
  EXPECT_FALSE(calib::poses_are_of_motion(straight_on(0.0)));
  EXPECT_TRUE(calib::poses_are_of_motion(straight_on(0.3)));
  MeasurementLog stops = straight_on(0.3);  // one pose and arrival a stop, nothing between
  for (std::size_t i = 0; i < stops.poses.size(); ++i)
    stops.poses[i].time_s = stops.arrivals[i].time_s = 60.0 * static_cast<double>(i);
  EXPECT_FALSE(calib::poses_are_of_motion(stops));
  // A reading as a stop begins and one as it ends.
  EXPECT_EQ(calib::share_with_pose(stops, 0.0), 1.0);
  EXPECT_EQ(calib::share_with_pose(stops, 0.64), 0.0);
  EXPECT_NEAR(calib::share_with_pose(straight_on(0.3), 0.95), 0.8, 0.021);
}

TEST(PoseClock, LateStampsAreTakenBack) {
  MeasurementLog run = straight_on(0.3);
  calib::take_back_lag(0.25, run);
  EXPECT_NEAR(run.poses[10].time_s, 0.75, 1e-12);
  EXPECT_NEAR(run.poses[10].T_map_vehicle.translation_m.x(), 0.3, 1e-12);
}

}  // namespace
}  // namespace octant::test
