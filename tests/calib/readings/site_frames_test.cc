// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// What each other frame makes of a site; which of them is found: tests/calib/readings/readings_test.cc.
#include "calib/readings/site_frames.h"

#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace {

/// Sense of the turn from receiver 0 by 1 to 2, as seen from above; its size is that of the triangle.
double turn_of(const Site& site) {
  const auto at = [&](std::size_t i) -> Eigen::Vector2d { return site.receivers[i].position_m.head<2>(); };
  const Eigen::Vector2d u = at(1) - at(0), v = at(2) - at(0);
  return u.x() * v.y() - u.y() * v.x();
}

TEST(SiteFrames, MirrorOrTurnTheReceiversAndMirrorTheMap) {
  Site site = cart().site;
  site.receivers[0].position_m = {0.3, 0.1, 0.2};  // no symmetry is left
  int mirrored = 0, turned = 0, maps = 0;
  for (const calib::Reading& reading : calib::other_site_frames(site)) {
    const Site other = reading.site(site);
    if (reading.what.kind == ContradictionKind::kExchanged) {
      ++maps;
      EXPECT_EQ(other.beacons[2].position_m[0], site.beacons[2].position_m[1]);
      EXPECT_EQ(other.beacons[2].sigma_m[1], site.beacons[2].sigma_m[0]);
      continue;
    }
    const bool is_mirror = reading.what.found.find("mirrored") != std::string::npos;
    EXPECT_NEAR(turn_of(other), is_mirror ? -turn_of(site) : turn_of(site), 1e-12) << reading.what.found;
    EXPECT_GE(other.receivers[0].sigma_m.minCoeff(), 0.0);
    (is_mirror ? mirrored : turned) += 1;
  }
  EXPECT_EQ(mirrored, 3);
  EXPECT_EQ(turned, 3);
  EXPECT_EQ(maps, 1);
}

// Each at another's place is another wiring, and has its reading there.
TEST(SiteFrames, LeaveOutWhatMovesNoReceiverElsewhere) {
  for (const calib::Reading& reading : calib::other_site_frames(hall_scenario().site)) {  // an octagon
    EXPECT_EQ(reading.what.kind, ContradictionKind::kExchanged) << reading.what.found;
  }
  Site one = hall_scenario().site;
  one.receivers.resize(1);
  one.vehicles[0].receiver_count = 1;
  for (SiteBeacon& b : one.beacons) b.position_m = {};
  EXPECT_TRUE(calib::other_site_frames(one).empty());
}

}  // namespace
}  // namespace octant::test
