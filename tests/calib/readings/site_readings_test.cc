// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Changes of a site under each hypothesis; for the search see tests/calib/readings/readings_test.cc.
#include "calib/readings/site_readings.h"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace site_readings_test {

Site hall_site() { return hall_scenario().site; }

TEST(OtherRanging, IsTheOtherOneAndBackAgain) {
  const Site site = hall_site();
  const auto readings = calib::other_ranging(site);
  ASSERT_EQ(readings.size(), 1U);
  const Site two_way = readings[0].site(site);
  EXPECT_EQ(two_way.timing.ranging, Ranging::kTwoWay);
  EXPECT_EQ(readings[0].what.kind, ContradictionKind::kRanging);
  EXPECT_EQ(readings[0].what.stated, "one_way");
  EXPECT_FALSE(readings[0].log) << "the recordings are as they are";
  const auto back = calib::other_ranging(two_way);
  EXPECT_EQ(back[0].site(two_way).timing.ranging, Ranging::kOneWay);
  EXPECT_EQ(back[0].what.stated, "two_way");
}

TEST(OtherRanging, IsNoneWhereEachEpochHasAClockOfItsOwn) {
  Site site = hall_site();
  site.timing.clock = Clock::kCycleOffset;
  EXPECT_TRUE(calib::other_ranging(site).empty());
}

TEST(OtherUnits, ScaleBeaconsReceiversOrBoth) {
  const Site site = hall_site();
  const auto readings = calib::other_units(site, {}, false);
  std::set<double> factors;
  bool beacons_alone = false, receivers_alone = false, both = false;
  for (const calib::Reading& reading : readings) {
    const Site other = reading.site(site);
    const double b = *other.beacons[3].position_m[0] / *site.beacons[3].position_m[0],
                 r = other.receivers[2].position_m.x() / site.receivers[2].position_m.x();
    for (std::size_t i = 0; i < 8; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(*other.beacons[i].position_m[k], b * *site.beacons[i].position_m[k], 1e-12);
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_LT((other.receivers[i].position_m - r * site.receivers[i].position_m).norm(), 1e-12);
    EXPECT_EQ(reading.what.kind, ContradictionKind::kUnits);
    beacons_alone = beacons_alone || (b != 1 && r == 1);
    receivers_alone = receivers_alone || (b == 1 && r != 1);
    both = both || (b != 1 && b == r);
    factors.insert(b != 1 ? b : r);
  }
  EXPECT_TRUE(beacons_alone && receivers_alone && both);
  for (const double unit_m : {0.01, 0.001, 0.3048, 0.0254}) {  // international foot and inch
    bool there = false;
    for (const double f : factors) there = there || std::abs(f - unit_m) < 1e-12;
    EXPECT_TRUE(there) << unit_m;
  }
}

TEST(OtherUnits, OfBeaconsWithoutPlacesAreOfReceiversAlone) {
  Site site = hall_site();
  for (SiteBeacon& b : site.beacons) b.position_m = {};
  for (const calib::Reading& reading : calib::other_units(site, {}, false))
    EXPECT_NE(reading.site(site).receivers[2].position_m, site.receivers[2].position_m);
  EXPECT_TRUE(calib::other_units(site, {}, true).empty());
}

TEST(OtherUnits, OfAHallInMetresHaveNoOddOnes) {
  EXPECT_TRUE(calib::other_units(hall_site(), {}, true).empty());
}

TEST(OtherUnits, NameTheBeaconsThatAloneAreOfAnotherMagnitude) {
  Site site = hall_site();
  for (const std::size_t b : {2U, 5U})
    for (auto& x : site.beacons[b].position_m) *x *= 100.0;
  bool mended = false;
  for (const calib::Reading& reading : calib::other_units(site, {}, true)) {
    if (reading.what.subject.find("B2, B5") == std::string::npos) continue;
    const Site other = reading.site(site);
    EXPECT_EQ(*other.beacons[1].position_m[0], *site.beacons[1].position_m[0]) << "the rest stays";
    mended =
        mended || std::abs(*other.beacons[5].position_m[0] - *hall_site().beacons[5].position_m[0]) < 1e-9;
  }
  EXPECT_TRUE(mended);
}

TEST(ExchangedPoints, AreEveryPairOfAFewControlPoints) {
  Site site = hall_site();  // B0, B3, B6
  const auto readings = calib::exchanged_points(site);
  ASSERT_EQ(readings.size(), 3U);
  std::set<std::string> names;
  for (const calib::Reading& reading : readings) names.insert(reading.what.subject);
  EXPECT_EQ(names, (std::set<std::string>{"B0, B3", "B0, B6", "B3, B6"}));
  const Site other = readings[0].site(site);
  EXPECT_EQ(other.beacons[0].position_m, site.beacons[3].position_m);
  EXPECT_EQ(other.beacons[3].position_m, site.beacons[0].position_m);
  EXPECT_EQ(other.beacons[6].position_m, site.beacons[6].position_m);
  EXPECT_EQ(other.beacons[0].name, "B0");
  for (const std::size_t b : {1U, 2U}) site.beacons[b].sigma_m = {0.0, 0.0, 0.0};
  EXPECT_TRUE(calib::exchanged_points(site).empty()) << "five are more than a few";
}

/// Orientation of the triangle of receivers 0, 1, 2, seen from above; its size is twice the triangle's area.
double turn_of(const Site& site) {
  const auto at = [&](std::size_t i) -> Eigen::Vector2d { return site.receivers[i].position_m.head<2>(); };
  const Eigen::Vector2d u = at(1) - at(0), v = at(2) - at(0);
  return u.x() * v.y() - u.y() * v.x();
}

TEST(SiteFrames, MirrorOrTurnTheReceiversAndMirrorTheMap) {
  Site site = cart().site;
  site.receivers[0].position_m = {0.3, 0.1, 0.2};  // no symmetry is left
  int mirrored = 0, turned = 0, maps = 0;
  for (const calib::Reading& reading :
       calib::joined({calib::other_receiver_axes(site), calib::mirrored_map(site)})) {
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

// Receivers at each other's positions are another wiring, which has its own hypothesis.
TEST(SiteFrames, LeaveOutWhatMovesNoReceiverElsewhere) {
  EXPECT_TRUE(calib::other_receiver_axes(hall_scenario().site).empty()) << "an octagon";
  Site one = hall_scenario().site;
  one.receivers.resize(1);
  one.vehicles[0].receiver_count = 1;
  for (SiteBeacon& b : one.beacons) b.position_m = {};
  EXPECT_TRUE(calib::other_receiver_axes(one).empty());
}

}  // namespace site_readings_test
}  // namespace octant::test
