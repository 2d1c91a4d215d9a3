// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Drives in space with odometry of six degrees of freedom, as inertial and visual odometry bring it.
#include "models/localizers/start/space_start.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/methods.h"
#include "models/simulator/random.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace space_start_test {

Scenario flight_scenario(double duration_s) {
  Scenario s = drive_scenario(duration_s);
  s.site.motion = Motion::kSpatial;
  s.log_odometry = true;
  return s;
}

/// Errors of fixes.
struct Errors {
  std::size_t fixes = 0, ok = 0, with_level = 0, beyond_level = 0;
  double largest_m = 0.0, largest_rad = 0.0, nees = 0.0;
};

Errors errors_of(const std::vector<Fix>& fixes, const std::vector<TimedPose>& truth) {
  Errors e;
  e.fixes = fixes.size();
  for (const Fix& fix : fixes) {
    Pose T;
    if (!fix.ok() || !interpolate_poses(truth, fix.time_s, 1.0, T)) continue;
    ++e.ok;
    Eigen::Matrix<double, 6, 1> off;
    off << fix.T_map_vehicle.translation_m - T.translation_m,
        log_rotation(T.rotation.conjugate() * fix.T_map_vehicle.rotation);
    e.largest_m = std::max(e.largest_m, off.head<3>().norm());
    e.largest_rad = std::max(e.largest_rad, off.tail<3>().norm());
    e.nees += off.dot(Eigen::LDLT<Eigen::MatrixXd>(fix.covariance).solve(off));
    if (fix.protection_level_m > 0) {
      ++e.with_level;
      e.beyond_level += off.head<2>().norm() > fix.protection_level_m;
    }
  }
  e.nees /= static_cast<double>(std::max<std::size_t>(e.ok, 1));
  return e;
}

std::vector<Fix> located(const Deployment& deployment, const MeasurementLog& run) {
  EXPECT_EQ(choose_method(deployment, run, {}).method, Method::kTracker);
  return must(locate_run(Method::kAuto, deployment, run, {}));
}

TEST(SpaceStart, OdometryTellsPlaceAndAttitude) {
  const World world = must(simulate(flight_scenario(60.0), 3));
  ASSERT_FALSE(world.heldout.odometry.back().is_planar());
  const Errors e = errors_of(located(world.truth, world.heldout), world.heldout.truth);
  EXPECT_GT(e.fixes, 300U);
  EXPECT_EQ(e.ok, e.fixes);
  EXPECT_LT(e.largest_m, 0.05);
  EXPECT_LT(e.largest_rad, 0.05);
  EXPECT_GT(e.nees, 3.0);
  EXPECT_LT(e.nees, 12.0);
  EXPECT_EQ(e.with_level, e.ok);
  EXPECT_EQ(e.beyond_level, 0U);
}

/// As on a robot: past data only.
TEST(SpaceStart, TheCausalFilterIsHonestAndUsesThePastAlone) {
  const World world = must(simulate(flight_scenario(60.0), 3));
  const MeasurementLog& run = world.heldout;
  const std::vector<Fix> fixes = track(run, world.truth, {.protect = true, .smooth = false});
  const Errors e = errors_of(fixes, run.truth);
  EXPECT_GT(e.ok, e.fixes * 8 / 10) << "until the start is clear there is none";
  EXPECT_LT(e.largest_m, 0.08);
  EXPECT_LT(e.largest_rad, 0.15);
  EXPECT_GT(e.nees, 3.0);
  EXPECT_LT(e.nees, 12.0);
  EXPECT_EQ(e.with_level, e.ok);
  EXPECT_EQ(e.beyond_level, 0U);
  MeasurementLog cut = run;
  const double until_s = run.arrivals[run.arrivals.size() / 2].time_s;
  std::erase_if(cut.arrivals, [&](const Arrival& a) { return a.time_s > until_s; });
  const std::vector<Fix> part = track(cut, world.truth, {.protect = true, .smooth = false});
  ASSERT_GT(part.size(), 100U);
  for (std::size_t i = 0; i < part.size(); ++i) {
    ASSERT_EQ(part[i].status, fixes[i].status) << i;
    EXPECT_EQ(part[i].T_map_vehicle.translation_m, fixes[i].T_map_vehicle.translation_m) << i;
  }
}

TEST(SpaceStart, AmongEchoes) {
  Scenario s = flight_scenario(60.0);
  s.echo_fraction = 0.15;
  const World world = must(simulate(s, 4));
  const Errors e = errors_of(located(world.truth, world.heldout), world.heldout.truth);
  EXPECT_EQ(e.ok, e.fixes);
  EXPECT_LT(e.largest_m, 0.06);
  EXPECT_LT(e.nees, 14.0);
}

/// A single antenna on a bent path through a hall whose beacons are at all heights.
struct Flight {
  Deployment deployment;
  MeasurementLog log;
};

Flight one_antenna(double seconds, std::uint64_t seed) {
  constexpr double kSpeed_mps = 340.0, kSigma_m = 0.03, kStep_s = 0.05;
  const Eigen::Vector3d places[] = {{0, 0, 0.3}, {10, 0, 4.0}, {10, 8, 0.5},
                                    {0, 8, 4.2}, {5, -1, 3.0}, {5, 9, 1.0}};
  Flight f;
  Deployment& d = f.deployment;
  d.motion = Motion::kSpatial;
  d.medium.model = MediumModel::kConstant;
  d.medium.speed_mps = kSpeed_mps;
  d.noise.tof_sigma_s = kSigma_m / kSpeed_mps;
  for (const Eigen::Vector3d& p : places) {
    DeploymentBeacon b;
    b.name = "B" + std::to_string(d.beacons.size());
    b.position_m = p;
    d.beacons.push_back(b);
  }
  d.vehicles.push_back({.name = "drone", .receiver_count = 1});
  DeploymentReceiver receiver;
  receiver.name = "r0";
  receiver.vehicle = VehicleId(0);
  receiver.position_m = {0.2, 0.1, -0.05};
  d.receivers.push_back(receiver);
  Random random(seed, 0);
  f.log.vehicle = VehicleId(0);
  f.log.odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.01, .heading_sigma_rad_per_sqrt_m = 0.01};
  const auto at = [](double t) {
    return Pose{{5 + 3 * std::cos(0.2 * t), 4 + 2 * std::sin(0.3 * t), 1.5 + std::sin(0.17 * t)},
                exp_rotation({0.2 * std::sin(0.4 * t), 0.2 * std::cos(0.3 * t), 0.5 * t})};
  };
  for (int k = 0; k * kStep_s <= seconds; ++k) {
    const double t = k * kStep_s;
    OdometryStep& step = f.log.odometry.emplace_back();
    step.time_s = t;
    step.vehicle = VehicleId(0);
    if (k > 0) {
      const Eigen::Vector3d slip = random.normal3(), twist = random.normal3();
      Pose T = at(t - kStep_s).inverse() * at(t);
      const double share = std::sqrt(T.translation_m.norm());
      T.translation_m += 0.01 * share * slip;
      T.rotation = T.rotation * exp_rotation(0.01 * share * twist);
      step.set_pose(T);
    }
    f.log.truth.push_back({t, at(t)});
    Arrival a;
    a.time_s = t;
    a.beacon = BeaconId(static_cast<std::size_t>(k) % d.beacons.size());
    a.receiver = ReceiverId(0);
    a.vehicle = VehicleId(0);
    a.tof_s = ((at(t) * receiver.position_m - d.beacons[a.beacon.index()].position_m).norm() +
               kSigma_m * random.normal()) /
              kSpeed_mps;
    f.log.arrivals.push_back(a);
  }
  f.log.rows = f.log.arrivals.size();
  return f;
}

// Alone it determines no attitude; odometry along a curved path does.
TEST(SpaceStart, ASingleAntennaHasAnAttitude) {
  const Flight f = one_antenna(40.0, 1);
  const Errors e = errors_of(located(f.deployment, f.log), f.log.truth);
  EXPECT_GT(e.fixes, 700U);
  EXPECT_EQ(e.ok, e.fixes);
  EXPECT_LT(e.largest_m, 0.15);
  EXPECT_LT(e.largest_rad, 0.1);
  EXPECT_GT(e.nees, 2.5);
  EXPECT_LT(e.nees, 14.0);
}

// A pause of reception is bridged, and a vehicle that was carried away is found again.
TEST(SpaceStart, SilenceIsBridged) {
  Flight f = one_antenna(60.0, 2);
  std::erase_if(f.log.arrivals, [](const Arrival& a) { return a.time_s > 20.0 && a.time_s < 35.0; });
  const Errors e = errors_of(located(f.deployment, f.log), f.log.truth);
  EXPECT_EQ(e.ok, e.fixes);
  EXPECT_LT(e.largest_m, 0.15);
}

// A straight path at a steady attitude leaves the turn about it open: the place follows from the arrivals
// alone, and no attitude is made up.
TEST(SpaceStart, AStraightPathOfOneAntennaTellsThePlaceAlone) {
  Flight f = one_antenna(10.0, 3);
  const Eigen::Vector3d step_m(0.03, 0.015, 0.0);
  Pose T{{2, 2, 1}, Eigen::Quaterniond::Identity()};
  Random random(3, 1);
  for (std::size_t k = 0; k < f.log.odometry.size(); ++k) {
    if (k > 0) T.translation_m += step_m;
    f.log.odometry[k].set_pose({k > 0 ? step_m : Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()});
    Arrival& a = f.log.arrivals[k];
    const Eigen::Vector3d way =
        T * f.deployment.receivers[0].position_m - f.deployment.beacons[a.beacon.index()].position_m;
    a.tof_s = (way.norm() + 0.03 * random.normal()) / 340.0;
    f.log.truth[k].T_map_vehicle = T;
  }
  const std::vector<Fix> fixes = located(f.deployment, f.log);
  const Errors e = errors_of(fixes, f.log.truth);
  EXPECT_EQ(e.ok, e.fixes);
  EXPECT_LT(e.largest_m, 0.4);
  for (const Fix& fix : fixes) EXPECT_GT(fix.covariance.diagonal().tail<3>().minCoeff(), 1.0);
}

TEST(SpaceStart, TooLittleIsNoPlace) {
  Flight f = one_antenna(10.0, 5);
  std::erase_if(f.log.arrivals, [](const Arrival& a) { return a.beacon.index() > 1; });
  for (const Fix& fix : located(f.deployment, f.log)) EXPECT_FALSE(fix.ok());
}

}  // namespace space_start_test
}  // namespace octant::test
