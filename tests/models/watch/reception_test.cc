// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/reception.h"

#include <cmath>

#include <gtest/gtest.h>

namespace octant {
namespace reception_test {

/// Four beacons in the corners of a hall, received within 12 m. Drives to and fro, two metres a place.
std::vector<BeaconId> silent_beacons(int places, int dead, int dies_at) {
  const std::vector<Eigen::Vector3d> beacons = {{0, 0, 3}, {20, 0, 3}, {0, 10, 3}, {20, 10, 3}};
  ReceptionWatch watch(beacons, 20.0);
  std::vector<BeaconId> silent;
  for (int k = 0; k < places; ++k) {
    const int phase = k % 20;
    const Eigen::Vector3d p(phase < 10 ? 2.0 * phase : 40.0 - 2.0 * phase, 5.0, 0.0);
    for (int b = 0; b < 4; ++b)
      if ((p - beacons[static_cast<std::size_t>(b)]).norm() < 12.0 && (b != dead || k < dies_at))
        watch.receive(BeaconId(b));
    if (const auto found = watch.leave_place(p, k)) silent.push_back(*found);
  }
  return silent;
}

TEST(Reception, ABeaconOutOfReachIsNotSilent) { EXPECT_TRUE(silent_beacons(400, -1, 0).empty()); }

TEST(Reception, ABeaconThatDiesIsReportedOnce) {
  EXPECT_EQ(silent_beacons(100, 2, 45), std::vector<BeaconId>{BeaconId(2)});
}

TEST(Reception, ABeaconThatIsDeadFromTheStartIsReportedToo) {
  EXPECT_EQ(silent_beacons(100, 1, 0), std::vector<BeaconId>{BeaconId(1)});
}

/// A beacon is received at twelve places around it. Another one 100 m away is dead and only half as far from
/// the vehicle, which shows that it should be received.
TEST(Reception, BeaconsFartherAwayBoundTheProbabilityOfAMiss) {
  const std::vector<Eigen::Vector3d> beacons = {{0, 0, 3}, {100, 0, 3}};
  ReceptionWatch watch(beacons, 20.0);
  std::vector<BeaconId> silent;
  const auto drive_around = [&](std::size_t beacon, double radius_m, int places) {
    for (int k = 0; k < places; ++k) {
      const double angle_rad = 2.0 * M_PI * k / places;
      const Eigen::Vector3d p = beacons[beacon] + Eigen::Vector3d(radius_m * std::cos(angle_rad),
                                                                  radius_m * std::sin(angle_rad), -3.0);
      if (beacon == 0) watch.receive(BeaconId(beacon));
      if (const auto found = watch.leave_place(p, k)) silent.push_back(*found);
    }
  };
  drive_around(0, 8.0, 12);
  EXPECT_TRUE(silent.empty());
  drive_around(1, 4.0, 14);
  EXPECT_EQ(silent, std::vector<BeaconId>{BeaconId(std::size_t{1})});
}

}  // namespace reception_test
}  // namespace octant
