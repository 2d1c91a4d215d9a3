// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/speed/one_speed.h"

#include <memory>

#include <gtest/gtest.h>

#include "models/localizers/methods.h"
#include "models/trajectory/ray_speeds.h"

namespace octant {
namespace one_speed_test {

/// Six transponders on a slope of the sea floor, a ship with one transducer, and a sea whose speed changes
/// with depth.
Deployment sea() {
  Deployment d;
  d.motion = Motion::kSpatial;
  d.medium.profile = std::make_shared<const SpeedProfile>(
      std::vector<SpeedProfile::Level>{{-3000, 1517}, {-800, 1482}, {-200, 1500}, {-50, 1525}, {0, 1528}});
  d.medium.speed_mps = d.medium.profile->mean_speed_mps(-2700, 0);
  d.speed_offset_mps = 0.4;
  d.noise.tof_sigma_s = 5e-5;
  const double places_m[6][3] = {{1000, 990, -2740}, {-960, 940, -2680}, {-980, -970, -2590},
                                 {940, -980, -2610}, {-200, 150, -1900}, {1500, -700, -1400}};
  for (const auto& p : places_m) {
    DeploymentBeacon b;
    b.name = "M" + std::to_string(d.beacons.size() + 1);
    b.position_m = {p[0], p[1], p[2]};
    b.status = BeaconStatus::kCalibrated;
    d.beacons.push_back(b);
  }
  d.vehicles.push_back({.name = "ship"});
  DeploymentReceiver r;
  r.name = "transducer";
  r.vehicle = VehicleId(0);
  r.position_m = {0, 0, -3};
  d.receivers.push_back(r);
  return d;
}

/// Arrivals at the ship without noise, by rays through the profile.
std::vector<Arrival> arrivals_at(const Deployment& d, const Eigen::Vector3d& ship_m, std::int64_t epoch) {
  std::vector<Arrival> arrivals;
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    const Eigen::Vector3d receiver_m = ship_m + d.receivers[0].position_m;
    Arrival a;
    a.time_s = 10.0 * static_cast<double>(epoch);
    a.beacon = BeaconId(b);
    a.receiver = ReceiverId(0);
    a.vehicle = VehicleId(0);
    a.epoch = epoch;
    const double speed_mps =
        d.medium.profile->effective_speed_mps(receiver_m, d.beacons[b].position_m) + d.speed_offset_mps;
    a.tof_s = (receiver_m - d.beacons[b].position_m).norm() / speed_mps;
    arrivals.push_back(a);
  }
  return arrivals;
}

TEST(RaySpeeds, ArrivalsAtOneSpeedLieOnStraightPaths) {
  const Deployment d = sea();
  Fix fix;
  fix.status = FixStatus::kOk;
  fix.vehicle = VehicleId(0);
  fix.epoch = 4;
  fix.T_map_vehicle.translation_m = {300, -200, 0};
  const auto straight =
      at_one_speed(arrivals_at(d, fix.T_map_vehicle.translation_m, 4), std::span(&fix, 1), d);
  for (const Arrival& a : straight) {
    const Eigen::Vector3d path_m =
        fix.T_map_vehicle.translation_m + d.receivers[0].position_m - d.beacons[a.beacon.index()].position_m;
    EXPECT_NEAR(a.tof_s * (d.medium.speed_mps + d.speed_offset_mps), path_m.norm(), 1e-6);
  }
}

TEST(RaySpeeds, WithoutAFixTheVehicleIsTakenToBeAtTheSurface) {
  const Deployment d = sea();
  // The transducer is at the surface, so the distance alone gives the path.
  const std::vector<Arrival> arrivals = arrivals_at(d, {300, -200, 3}, 4);
  for (const Arrival& a : at_one_speed(arrivals, {}, d)) {
    const double path_m = (Eigen::Vector3d(300, -200, 0) - d.beacons[a.beacon.index()].position_m).norm();
    EXPECT_NEAR(a.tof_s * (d.medium.speed_mps + d.speed_offset_mps), path_m, 0.05);
  }
}

TEST(RaySpeeds, OfATrajectoryAreThoseOfItsRays) {
  const Deployment d = sea();
  const Eigen::Vector3d ship_m(300, -200, 0);
  Trajectory t;
  t.motion = Motion::kSpatial;
  t.nodes.push_back({.T_map_vehicle = {.translation_m = ship_m}, .placed = true});
  for (std::size_t b = 0; b < 4; ++b) {
    ArrivalObservation a;
    a.beacon = BeaconId(b);
    a.receiver = ReceiverId(0);
    a.model_speed_mps = d.medium.speed_mps;
    t.arrivals.push_back(a);
  }
  const SharedState state = shared_state(d);
  EXPECT_GT(set_ray_speeds(t, state, *d.medium.profile), 0.01);
  EXPECT_EQ(set_ray_speeds(t, state, *d.medium.profile), 0.0) << "nothing has moved";
  const Eigen::Vector3d receiver_m = ship_m + d.receivers[0].position_m;
  EXPECT_EQ(t.arrivals[2].model_speed_mps,
            d.medium.profile->effective_speed_mps(receiver_m, d.beacons[2].position_m));
}

TEST(RaySpeeds, FixesFollowTheRays) {
  const Deployment d = sea();
  MeasurementLog run;
  run.has_epochs = true;
  for (std::int64_t e = 0; e < 3; ++e) {
    const auto some = arrivals_at(d, {100.0 * static_cast<double>(e), -200, 1.5}, e);
    run.arrivals.insert(run.arrivals.end(), some.begin(), some.end());
  }
  const auto fixes = locate_run(Method::kAuto, d, run, {});
  ASSERT_TRUE(fixes) << fixes.error().message();
  ASSERT_EQ(fixes->size(), 3u);
  for (const Fix& fix : *fixes) {
    ASSERT_TRUE(fix.ok()) << static_cast<int>(fix.status);
    const Eigen::Vector3d truth_m(100.0 * static_cast<double>(fix.epoch), -200, 1.5);
    EXPECT_LT((fix.T_map_vehicle.translation_m - truth_m).head<2>().norm(), 0.01);
  }
}

}  // namespace one_speed_test
}  // namespace octant
