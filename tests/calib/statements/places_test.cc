// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Tests of hypotheses about the positions of taped beacons.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace places_test {

using testing::HasSubstr;
using testing::IsEmpty;

/// Sixty stops in a hall in which all beacons are taped to a centimetre.
Scenario taped_hall() {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {0.01, 0.01, 0.01};
  return s;
}

// The prior of a taped beacon was not tested. With noise that is large compared to the prior, the beacon kept
// its place, and lost arrivals.
TEST(Places, ATapedBeaconThatIsElsewhereIsNamed) {
  Scenario s = taped_hall();
  s.site.noise.tof_sigma_s = 5e-4;  // 0.17 m
  EXPECT_THAT(explained(must(simulate(s, 13))), IsEmpty());
  World world = must(simulate(s, 13));
  *world.site.beacons[4].position_m[1] -= 0.8;
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kBeacon);
  EXPECT_EQ(found[0].subject, "B4");
  EXPECT_THAT(found[0].stated, HasSubstr("sigma 10.0 mm"));
  EXPECT_THAT(found[0].remedy, HasSubstr("survey beacon B4"));
}

// Eight positions were disregarded one by one, and the map was exported elsewhere.
TEST(Places, HeightsOfTapedBeaconsThatCountDownwardsAreOneError) {
  World world = must(simulate(taped_hall(), 14));
  for (SiteBeacon& b : world.site.beacons) b.position_m[2] = -*b.position_m[2];
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kExchanged);
  EXPECT_THAT(found[0].found, HasSubstr("heights count downwards"));
}

// Control points were blamed one by one until the time for the search was over.
TEST(Places, HeightsOfSurveyedBeaconsThatCountDownwardsComeFirst) {
  Scenario s = taped_hall();
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {0.0, 0.0, 0.0};
  World world = must(simulate(s, 16));
  for (SiteBeacon& b : world.site.beacons) b.position_m[2] = -*b.position_m[2];
  const auto found = solution_of(world).contradictions;
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found[0].found, HasSubstr("heights count downwards"));
}

// The control point was found at the position of the taped beacon, and the taped beacon elsewhere.
TEST(Places, AControlPointExchangedWithATapedBeaconIsNamed) {
  World world = must(simulate(taped_hall(), 17));
  world.site.beacons[2].sigma_m = {0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < 3; ++i)
    world.site.beacons[2].position_m[i] = world.truth.beacons[2].position_m[static_cast<Eigen::Index>(i)];
  std::swap(world.site.beacons[2].position_m, world.site.beacons[5].position_m);
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kExchanged);
  EXPECT_EQ(found[0].subject, world.site.beacons[2].name + ", " + world.site.beacons[5].name);
}

// Delays of the beacons were blamed, because they absorb a part of a move.
TEST(Places, ABeaconThatMovedIsNamedWithoutDelaysInTheSiteFile) {
  Scenario s = taped_hall();
  s.site.timing.delay_per = {};
  s.site.timing.delay_s = s.site.timing.delay_sigma_s = 0.0;
  World world = must(simulate(s, 15));
  World moved = world;
  const Eigen::Vector3d by_m(0.12, -0.04, 0.0);
  const double speed = speed_mps(world.site.medium);
  const double middle_s = world.run.arrivals[world.run.arrivals.size() / 2].time_s;
  for (Arrival& a : moved.run.arrivals) {
    if (a.beacon.index() != 4 || a.time_s < middle_s) continue;
    Pose pose;
    ASSERT_TRUE(interpolate_poses(world.run.truth, a.time_s, 10.0, pose));
    const Eigen::Vector3d at_m = pose * world.site.receivers[a.receiver.index()].position_m,
                          b_m = world.truth.beacons[4].position_m;
    a.tof_s += ((b_m + by_m - at_m).norm() - (b_m - at_m).norm()) / speed;
  }
  const auto found = explained(moved);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].subject, "B4") << in_words(found[0]);
  EXPECT_THAT(found[0].found, HasSubstr("to move by 12"));
}

}  // namespace places_test
}  // namespace octant::test
