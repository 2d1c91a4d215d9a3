// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/validity.h"

#include <gtest/gtest.h>

namespace octant::calib {
namespace validity_test {

/// Stops every metre along a hall, beacons every four metres on its wall; those within a given range are
/// received.
struct Corridor {
  std::vector<DeploymentBeacon> beacons;
  Trajectory stops;

  Corridor(double length_m, double reach_m) {
    for (double x = 0; x <= length_m; x += 4) {
      beacons.emplace_back();
      beacons.back().position_m = {x, 3, 2.5};
    }
    for (double x = 0; x <= length_m; x += 0.5) {
      Node node;
      node.T_map_vehicle.translation_m = {x, 0, 0};
      node.placed = true;
      for (std::size_t b = 0; b < beacons.size(); ++b) {
        if ((beacons[b].position_m - node.T_map_vehicle.translation_m).norm() > reach_m) continue;
        ArrivalObservation arrival;
        arrival.node = static_cast<std::uint32_t>(stops.nodes.size());
        arrival.beacon = BeaconId(static_cast<std::int32_t>(b));
        stops.arrivals.push_back(arrival);
      }
      stops.nodes.push_back(node);
    }
  }
};

TEST(ValidSpace, HasHeightsInSpaceOnly) {
  Corridor hall(60, 16);
  for (std::size_t i = 0; i < hall.stops.nodes.size(); ++i)
    hall.stops.nodes[i].T_map_vehicle.translation_m.z() = 0.01 * static_cast<double>(i);
  hall.stops.nodes.front().placed = false;
  hall.stops.arrivals.clear();
  Deployment d;
  set_valid_space(extent_of(hall.stops, {}, {}), d);
  EXPECT_FALSE(d.validity_heights_m);
  d.motion = Motion::kSpatial;
  set_valid_space(extent_of(hall.stops, {}, {}), d);
  ASSERT_TRUE(d.validity_heights_m);
  EXPECT_DOUBLE_EQ(d.validity_heights_m->front(), 0.01);
  EXPECT_DOUBLE_EQ(d.validity_heights_m->back(), 1.2);
}

TEST(Reach, IsWhereHearingEnds) {
  const Corridor hall(60, 16);
  const auto reach_m = heard_reach_m({hall.stops}, hall.beacons);
  ASSERT_TRUE(reach_m);
  EXPECT_GT(*reach_m, 15.0);  // stops are half a metre apart
  EXPECT_LE(*reach_m, 16.0);
}

TEST(Reach, IsNotKnownWhereAllIsHeard) {
  const Corridor hall(60, 100);
  EXPECT_FALSE(heard_reach_m({hall.stops}, hall.beacons));
}

TEST(Reach, IsNotKnownFromFewArrivals) {
  const Corridor hall(24, 10);  // some 170 pairs
  ASSERT_LT(hall.stops.arrivals.size(), 200U);
  EXPECT_FALSE(heard_reach_m({hall.stops}, hall.beacons));
}

TEST(Reach, LooksAtNoBeaconWhosePlaceIsUnknown) {
  Corridor hall(60, 100);
  // Silent, and placed anywhere.
  for (int i = 0; i < 3; ++i) {
    hall.beacons.emplace_back();
    hall.beacons.back().position_m = {500, 0, 0};
    hall.beacons.back().status = BeaconStatus::kUndetermined;
  }
  EXPECT_FALSE(heard_reach_m({hall.stops}, hall.beacons));
  for (DeploymentBeacon& beacon : hall.beacons) beacon.status = BeaconStatus::kCalibrated;
  EXPECT_TRUE(heard_reach_m({hall.stops}, hall.beacons));
}

TEST(Reach, OfADriveThatHearsOneBeaconAtATime) {
  // At each time one of the beacons in range is received, alternately: missing ones are no evidence of the
  // range.
  for (const double reach_m : {16.0, 100.0}) {
    Corridor hall(60, reach_m);
    Trajectory drive;
    for (int lap = 0; lap < 16; ++lap)
      for (std::size_t n = 0; n < hall.stops.nodes.size(); ++n) {
        std::vector<ArrivalObservation> here;
        for (const ArrivalObservation& a : hall.stops.arrivals)
          if (a.node == n) here.push_back(a);
        if (here.empty()) continue;
        here[static_cast<std::size_t>(lap) % here.size()].node =
            static_cast<std::uint32_t>(drive.nodes.size());
        drive.arrivals.push_back(here[static_cast<std::size_t>(lap) % here.size()]);
        drive.nodes.push_back(hall.stops.nodes[n]);
      }
    const auto found_m = heard_reach_m({drive}, hall.beacons);
    EXPECT_EQ(found_m.has_value(), reach_m < 50) << reach_m;
    if (found_m) {
      EXPECT_NEAR(*found_m, 15.7, 0.7);
    }
  }
}

}  // namespace validity_test
}  // namespace octant::calib
