// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/known_parameters.h"

#include <cmath>

#include <gtest/gtest.h>

namespace octant {
namespace known_parameters_test {

Deployment small_site() {
  Deployment d;
  for (const char* name : {"A", "B", "C"}) {
    DeploymentBeacon b;
    b.name = name;
    d.beacons.push_back(b);
  }
  d.beacons[1].status = BeaconStatus::kUndetermined;
  d.vehicles.push_back({"robot", 0, 1});
  DeploymentReceiver r;
  r.name = "r0";
  r.vehicle = VehicleId(std::size_t{0});
  r.position_m = {0.03, 0.04, 0.3};
  d.receivers.push_back(r);
  return d;
}

TEST(KnownParameters, UndeterminedBeaconsAreNotKnown) {
  const KnownParameters known = known_parameters(small_site());
  EXPECT_EQ(known.index_of({ParameterKind::kBeaconPosition, 1, 0}), -1);
  EXPECT_EQ(known.size(), 2 * 4 + 3 + 1);  // places and delays, a receiver, the speed
  EXPECT_EQ(parameter_name(known.parameters[4], names_of(small_site())), "beacon/C/x_m");
}

TEST(KnownParameters, ASitesOneDelayStandsOnEveryBeacon) {
  Deployment d = small_site();
  d.timing.delay_per.site = true;
  d.covariance.parameters = {parameters::site_delay()};
  d.covariance.matrix = Eigen::MatrixXd::Constant(1, 1, 4e-12);
  const KnownParameters known = known_parameters(d);
  const int a = known.index_of({ParameterKind::kBeaconDelay, 0, 0}),
            c = known.index_of({ParameterKind::kBeaconDelay, 2, 0});
  EXPECT_DOUBLE_EQ(known.covariance(a, c), 4e-12);
  EXPECT_DOUBLE_EQ(known.covariance(a, a), 4e-12);
}

TEST(KnownParameters, AnOctagonsRadiusAndTurnMoveItsReceivers) {
  Deployment d = small_site();
  d.covariance.parameters = {parameters::array_radius(0), parameters::array_turn(0)};
  d.covariance.matrix = Eigen::Vector2d(1e-6, 1e-4).asDiagonal();
  const KnownParameters known = known_parameters(d);
  const int x = known.index_of({ParameterKind::kReceiverPosition, 0, 0});
  EXPECT_NEAR(known.covariance(x, x), 0.36e-6 + 0.0016e-4, 1e-15);
  EXPECT_NEAR(known.covariance(x, x + 1), 0.48e-6 - 0.0012e-4, 1e-15);
  EXPECT_EQ(known.covariance(x + 2, x + 2), 0.0);
}

TEST(KnownParameters, MotionsOfTheMapKeepItsDistances) {
  Deployment d = small_site();
  d.beacons[0].position_m = {1, 2, 3};
  d.beacons[2].position_m = {4, 6, 3};
  const KnownParameters known = known_parameters(d);
  const Eigen::MatrixXd T = map_motions(known, Motion::kPlanar);
  const int a = known.index_of({ParameterKind::kBeaconPosition, 0, 0}),
            c = known.index_of({ParameterKind::kBeaconPosition, 2, 0});
  const Eigen::Vector3d between = d.beacons[2].position_m - d.beacons[0].position_m;
  for (Eigen::Index k = 0; k < T.cols(); ++k)
    EXPECT_NEAR(between.dot(T.block<3, 1>(c, k) - T.block<3, 1>(a, k)), 0.0, 1e-12);
  EXPECT_EQ(map_motions(known, Motion::kSpatial).cols(), 6);
}

}  // namespace known_parameters_test
}  // namespace octant
