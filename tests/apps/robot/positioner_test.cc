// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Compares the robot library with the modules that it uses, row by row.
#include "apps/robot/octant/positioner.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "io/deployment/deployment_json.h"
#include "models/live/follower.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/trajectory.h"
#include "tests/apps/robot/robot.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace positioner_test {

Moved planar(const OdometryStep& s) { return {s.time_s, s.dx_m, s.dy_m, s.dheading_rad}; }
Moved spatial(const OdometryStep& s) {
  const Pose T = s.pose();
  return {.time_s = s.time_s,
          .dx_m = T.translation_m.x(),
          .dy_m = T.translation_m.y(),
          .dz_m = T.translation_m.z(),
          .qx = T.rotation.x(),
          .qy = T.rotation.y(),
          .qz = T.rotation.z(),
          .qw = T.rotation.w()};
}

OdometryNoise noise_of(const OdometryAccuracy& a) {
  return {a.distance_sigma_m_per_sqrt_m, a.heading_sigma_rad_per_sqrt_m, a.heading_sigma_per_rad, a.floor_m,
          a.floor_rad};
}

Scenario drive_of(Motion motion) {
  Scenario s = drive_scenario(30.0);
  s.site.motion = motion;
  s.log_odometry = true;
  return s;
}

void expect_same_covariance(const Place& place, const Fix& fix) {
  const Eigen::Matrix<double, 6, 6> C = covariance_in_map(fix.covariance, fix.T_map_vehicle);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) EXPECT_NEAR(place.covariance[i][j], C(i, j), 1e-9);
  EXPECT_STREQ(place.integrity, to_string(integrity(fix)));
}

void expect_same_velocity(const Place& place, const Fix& fix) {
  ASSERT_TRUE(place.has_velocity && fix.velocity);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(place.velocity_mps[i], fix.velocity->mean[i], 1e-7);
    EXPECT_NEAR(place.turn_rate_radps[i], fix.velocity->mean[3 + i], 1e-7);
    EXPECT_NEAR(place.sigma_velocity_mps[i], std::sqrt(fix.velocity->variance[i]), 1e-7);
    EXPECT_NEAR(place.sigma_turn_rate_radps[i], std::sqrt(fix.velocity->variance[3 + i]), 1e-7);
  }
}

/// The places of a positioner and the fixes of a follower that get the same rows.
void expect_followed(Motion motion) {
  const World world = must(simulate(drive_of(motion), 5));
  const Robot robot(world);
  const MeasurementLog& log = world.heldout;
  Positioner positioner(robot.path(), noise_of(log.odometry_accuracy));
  ASSERT_TRUE(positioner) << positioner.error();
  std::vector<Place> places;
  positioner.on_place([&](const Place& place) { places.push_back(place); });
  FollowOptions options;
  options.odometry = log.odometry_accuracy;
  Follower follower(must(io::read_deployment(robot.path())), options);
  std::vector<Fix> fixes;
  follower.on_fix = [&](const Fix& fix) { fixes.push_back(fix); };
  std::size_t next = 0;
  for (const OdometryStep& step : log.odometry) {
    for (; next < log.arrivals.size() && log.arrivals[next].time_s <= step.time_s; ++next) {
      EXPECT_TRUE(positioner.hear(robot.heard(log.arrivals[next])));
      follower.hear(log.arrivals[next]);
    }
    EXPECT_TRUE(positioner.move(motion == Motion::kPlanar ? planar(step) : spatial(step)));
    follower.move(step);
  }
  positioner.flush();
  follower.flush();
  ASSERT_EQ(places.size(), fixes.size());
  std::size_t placed = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_EQ(places[i].ok, fixes[i].ok());
    EXPECT_EQ(places[i].time_s, fixes[i].time_s);
    if (!places[i].ok) continue;
    ++placed;
    const Pose& T = fixes[i].T_map_vehicle;
    const Pose found{{places[i].x_m, places[i].y_m, places[i].z_m},
                     {places[i].qw, places[i].qx, places[i].qy, places[i].qz}};
    EXPECT_LT((found.translation_m - T.translation_m).norm(), 1e-7);
    EXPECT_LT(found.rotation.angularDistance(T.rotation), 1e-7);
    EXPECT_NEAR(places[i].heading_rad, T.heading_rad(), 1e-7);
    EXPECT_NEAR(places[i].sigma_x_m, std::sqrt(fixes[i].covariance(0, 0)), 1e-7);
    EXPECT_NEAR(places[i].sigma_z_m, motion == Motion::kPlanar ? 0.0 : std::sqrt(fixes[i].covariance(2, 2)),
                1e-7);
    expect_same_covariance(places[i], fixes[i]);
    expect_same_velocity(places[i], fixes[i]);
  }
  EXPECT_GT(placed, 200u);
  const double soon_s = log.odometry.back().time_s + 0.1;
  Fix soon;
  follower.predict(VehicleId(0), soon_s, soon);
  const Place predicted = positioner.predict(soon_s);
  ASSERT_TRUE(predicted.ok && soon.ok());
  EXPECT_EQ(predicted.time_s, soon_s);
  EXPECT_NEAR(predicted.x_m, soon.T_map_vehicle.translation_m.x(), 1e-7);
  expect_same_covariance(predicted, soon);
  EXPECT_FALSE(positioner.predict(soon_s, "nobody").ok);
}

MovedTo moved_to(double time_s, const Pose& T, Motion motion) {
  const Eigen::Vector3d& p = T.translation_m;
  const Eigen::Quaterniond& q = T.rotation;
  if (motion == Motion::kPlanar) return {time_s, p.x(), p.y(), T.heading_rad()};
  return {time_s, p.x(), p.y(), 0.0, {}, p.z(), q.x(), q.y(), q.z(), q.w()};
}

/// Places of a drive with odometry as steps, or as poses of which every third one is lost.
std::vector<Place> places_of(const World& world, bool as_poses) {
  const Robot robot(world);
  const MeasurementLog& log = world.heldout;
  const Motion motion = world.truth.motion;
  Positioner positioner(robot.path(), noise_of(log.odometry_accuracy));
  std::vector<Place> places;
  positioner.on_place([&](const Place& place) { places.push_back(place); });
  Pose T;
  for (std::size_t next = 0, row = 0; row < log.odometry.size(); ++row) {
    const OdometryStep& step = log.odometry[row];
    if (row > 0) T = T * step.pose();
    for (; next < log.arrivals.size() && log.arrivals[next].time_s <= step.time_s; ++next)
      positioner.hear(robot.heard(log.arrivals[next]));
    if (!as_poses) {
      EXPECT_TRUE(positioner.move(motion == Motion::kPlanar ? planar(step) : spatial(step)));
    } else if (row % 3 != 1) {
      EXPECT_TRUE(positioner.move_to(moved_to(step.time_s, T, motion)));
    }
  }
  positioner.flush();
  return places;
}

double rms_error_m(const std::vector<Place>& places, const MeasurementLog& log) {
  double sum_m2 = 0.0, count = 0.0;
  for (const Place& place : places) {
    Pose truth;
    if (!place.ok || !interpolate_poses(log.truth, place.time_s, 1.0, truth)) continue;
    sum_m2 += (Eigen::Vector3d(place.x_m, place.y_m, place.z_m) - truth.translation_m).squaredNorm();
    ++count;
  }
  EXPECT_GT(count, 200.0);
  return std::sqrt(sum_m2 / count);
}

TEST(Positioner, LostPosesOfOdometryLoseNoMotion) {
  for (const Motion motion : {Motion::kPlanar, Motion::kSpatial}) {
    const World world = must(simulate(drive_of(motion), 5));
    // As in FollowerIntegrity: a third less odometry is worth less than 30 % of accuracy.
    EXPECT_LT(rms_error_m(places_of(world, true), world.heldout),
              1.3 * rms_error_m(places_of(world, false), world.heldout));
  }
}

TEST(Positioner, FollowsInThePlane) { expect_followed(Motion::kPlanar); }
TEST(Positioner, FollowsInSpaceByOdometryWithQuaternions) { expect_followed(Motion::kSpatial); }

TEST(Positioner, AStepIsATurnOrAQuaternionNeverBoth) {
  const World world = must(simulate(drive_of(Motion::kSpatial), 5));
  const Robot robot(world);
  Positioner positioner(robot.path());
  ASSERT_TRUE(positioner) << positioner.error();
  const double half = std::sqrt(0.5);
  EXPECT_TRUE(positioner.move({.time_s = 1.0}));
  EXPECT_FALSE(positioner.move({.time_s = 2.0, .dheading_rad = 0.1, .qz = half, .qw = half}));
  EXPECT_FALSE(positioner.move({.time_s = 2.0, .qw = 0.0})) << "no rotation";
  EXPECT_FALSE(positioner.move({.time_s = 2.0, .qx = NAN}));
  EXPECT_TRUE(positioner.move({.time_s = 2.0, .qz = 2 * half, .qw = 2 * half})) << "of any length";
  EXPECT_FALSE(positioner.move({.time_s = 2.0, .vehicle = "nobody"}));
  EXPECT_FALSE(positioner.move_to({.time_s = 3.0, .heading_rad = 0.1, .qz = half, .qw = half}));
  EXPECT_FALSE(positioner.move_to({.time_s = 3.0, .heading_rad = NAN}));
}

TEST(Positioner, LocatesAStopAsTheLocalizerDoes) {
  const World world = must(simulate(hall_scenario(), 5));
  const Robot robot(world);
  Positioner positioner(robot.path());
  ASSERT_TRUE(positioner) << positioner.error();
  LeastSquaresLocalizer localizer(must(io::read_deployment(robot.path())));
  const std::vector<Arrival>& all = world.heldout.arrivals;
  std::size_t located = 0;
  for (std::size_t i = 0, last = 0; i < all.size(); i = last) {
    while (last < all.size() && all[last].epoch == all[i].epoch) ++last;
    std::vector<Heard> heard;
    for (std::size_t k = i; k < last; ++k) heard.push_back(robot.heard(all[k]));
    const Place place = positioner.locate(heard);
    const Fix fix = localizer.locate({all.data() + i, last - i});
    ASSERT_EQ(place.ok, fix.ok());
    EXPECT_STREQ(place.status, to_string(fix.status));
    if (!place.ok) continue;
    ++located;
    EXPECT_NEAR(place.x_m, fix.T_map_vehicle.translation_m.x(), 1e-9);
    EXPECT_NEAR(place.y_m, fix.T_map_vehicle.translation_m.y(), 1e-9);
    EXPECT_NEAR(place.covariance_xy_m2, fix.covariance(0, 1), 1e-15);
    EXPECT_EQ(place.arrivals_used, fix.arrivals_used);
  }
  EXPECT_GT(located, 30u);
}

TEST(Positioner, WatchNamesABeaconWhoseDelayChanged) {
  const World world = must(simulate(hall_scenario(), 5));
  const Robot robot(world);
  Positioner positioner(robot.path(), {}, 0.2, true);
  ASSERT_TRUE(positioner) << positioner.error();
  std::vector<std::string> kinds, names;
  positioner.on_alarm([&](const Alarm& alarm) {
    kinds.emplace_back(alarm.kind);
    names.emplace_back(alarm.name);
    EXPECT_NEAR(alarm.size_m, 2e-4 * 343.0, 0.03);
    EXPECT_TRUE(alarm.vehicle.empty());
  });
  // The recording again and again: a change shows in the number of its arrivals.
  const std::vector<Arrival>& all = world.heldout.arrivals;
  const double period_s = all.back().time_s - all.front().time_s + 10.0;
  for (int round = 0; round < 8 && names.empty(); ++round)
    for (const Arrival& a : all) {
      Heard heard = robot.heard(a);
      heard.time_s += round * period_s;
      heard.epoch = a.epoch + 1000 * round;
      if (a.beacon == BeaconId(2)) heard.tof_s += 2e-4;
      positioner.hear(heard);
    }
  EXPECT_EQ(kinds, std::vector<std::string>{"beacon_late"});
  EXPECT_EQ(names, std::vector<std::string>{world.truth.beacons[2].name});
}

TEST(Positioner, SaysWhatItCannotRead) {
  Positioner positioner("no/such/deployment.json");
  EXPECT_FALSE(positioner);
  EXPECT_NE(positioner.error().find("no/such/deployment.json"), std::string::npos);
  EXPECT_FALSE(positioner.locate({}).ok);
  EXPECT_FALSE(positioner.hear({.beacon = "B0", .tof_s = 0.01}));
  EXPECT_FALSE(positioner.move({.time_s = 1.0}));
  EXPECT_FALSE(positioner.predict(1.0).ok);
  positioner.flush();
}

TEST(Positioner, OdometryNoiseIsANumberFromZeroOn) {
  const Robot robot(must(simulate(hall_scenario(), 5)));
  EXPECT_TRUE(Positioner(robot.path(), {.distance_sigma_m_per_sqrt_m = 0.0}));
  for (const double wrong : {-0.01, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const Positioner positioner(robot.path(), {.floor_m = wrong});
    EXPECT_FALSE(positioner) << wrong;
    EXPECT_NE(positioner.error().find("odometry"), std::string::npos) << positioner.error();
  }
}

TEST(Positioner, MovesWithItsSink) {
  const World world = must(simulate(hall_scenario(), 5));
  const Robot robot(world);
  Positioner first(robot.path());
  ASSERT_TRUE(first) << first.error();
  int places = 0;
  first.on_place([&places](const Place&) { ++places; });
  Positioner second = std::move(first);
  for (const Arrival& a : world.heldout.arrivals)
    if (a.epoch == world.heldout.arrivals.front().epoch) {
      EXPECT_TRUE(second.hear(robot.heard(a)));
    }
  EXPECT_FALSE(second.hear({.beacon = "nobody", .tof_s = 0.01, .time_s = 1e-3}));
  second.flush();
  EXPECT_EQ(places, 1);
}

TEST(Positioner, ReadsADeploymentFromMemory) {
  const World world = must(simulate(hall_scenario(), 5));
  EXPECT_TRUE(Positioner::from_text(io::deployment_to_json(world.truth)));
  const Positioner empty = Positioner::from_text("{}");
  EXPECT_FALSE(empty);
  EXPECT_NE(empty.error(), "");
}

}  // namespace positioner_test
}  // namespace octant::test
