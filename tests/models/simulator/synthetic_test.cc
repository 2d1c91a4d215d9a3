// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Content of a simulated world, compared with formulas written here: measurement equation, reception, drive,
// site.
#include "models/simulator/synthetic.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "models/physics/attenuation.h"
#include "models/trajectory/shared_state.h"
#include "tests/support/worlds.h"

namespace octant {
namespace synthetic_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::drive_scenario;
using test::hall_scenario;
using test::must;
using test::without_noise;

/// Place of a receiver in the map, by hand for planar motion.
Vector3d receiver_in_map(const Pose& T, const Vector3d& o) {
  const double c = std::cos(T.heading_rad()), s = std::sin(T.heading_rad());
  return {T.translation_m.x() + c * o.x() - s * o.y(), T.translation_m.y() + s * o.x() + c * o.y(), o.z()};
}

/// Truth at an instant: exact rows, or linear between neighbours (all rotations here are about z).
Pose truth_at(const MeasurementLog& log, double time_s) {
  std::size_t i = 0;
  while (i + 2 < log.truth.size() && log.truth[i + 1].time_s <= time_s) ++i;
  const TimedPose &a = log.truth[i], &b = log.truth[i + 1];
  const double alpha = (time_s - a.time_s) / (b.time_s - a.time_s);
  const Vector3d p = (1 - alpha) * a.T_map_vehicle.translation_m + alpha * b.T_map_vehicle.translation_m;
  const double h = a.T_map_vehicle.heading_rad();
  return Pose::planar(p.x(), p.y(), h + alpha * wrap_angle(b.T_map_vehicle.heading_rad() - h));
}

double distance_m(const World& w, const Arrival& a, const Pose& T) {
  const Vector3d o = w.truth.receivers[a.receiver.index()].position_m;
  return (receiver_in_map(T, o) - w.truth.beacons[a.beacon.index()].position_m).norm();
}

TEST(Synthetic, SameSeedSameWorld) {
  const World a = must(simulate(hall_scenario(), 7)), b = must(simulate(hall_scenario(), 7)),
              c = must(simulate(hall_scenario(), 8));
  ASSERT_EQ(a.run.arrivals.size(), b.run.arrivals.size());
  for (std::size_t i = 0; i < a.run.arrivals.size(); ++i)
    EXPECT_EQ(a.run.arrivals[i].tof_s, b.run.arrivals[i].tof_s);
  EXPECT_EQ(a.site.beacons[1].position_m, b.site.beacons[1].position_m);
  EXPECT_NE(a.site.beacons[1].position_m, c.site.beacons[1].position_m);
  EXPECT_NE(a.run.arrivals[0].tof_s, c.run.arrivals[0].tof_s);
}

TEST(Synthetic, PartsOfAWorldDoNotDisturbEachOther) {
  const World plain = must(simulate(hall_scenario(), 3));
  Scenario changed = hall_scenario();
  changed.heldout_path.epochs = 10;
  changed.echo_fraction = 0.3;
  const World other = must(simulate(changed, 3));
  EXPECT_EQ(plain.site.beacons[1].position_m, other.site.beacons[1].position_m);
  std::map<double, double> direct;  // an echo moves an arrival in time, and so in the order
  for (std::size_t i = 0; i < other.run.arrivals.size(); ++i)
    direct[other.run.arrivals[i].tof_s] = other.run_lateness_s[i];
  std::size_t shared = 0;
  for (const Arrival& a : plain.run.arrivals) shared += direct.count(a.tof_s);
  EXPECT_NEAR(static_cast<double>(shared) / static_cast<double>(plain.run.arrivals.size()), 0.7, 0.06);
}

TEST(Synthetic, NoiseFreeStopsFollowTheMeasurementEquation) {
  Scenario s = without_noise(hall_scenario());
  s.site.medium = {.model = MediumModel::kLinearTemperature, .temperature_degC = 21.0};
  const World w = must(simulate(s, 1));
  const double c = 331.3 + 0.606 * 22.5;
  ASSERT_GT(w.run.arrivals.size(), 1500u);
  for (const Arrival& a : w.run.arrivals) {
    const Pose T = truth_at(w.run, a.time_s);
    EXPECT_NEAR(a.tof_s, distance_m(w, a, T) / c + w.truth.beacons[a.beacon.index()].delay_s, 1e-15);
    const double fired_s = 10.0 + 5.0 * static_cast<double>(a.epoch) + 0.05 * a.beacon.value;
    EXPECT_NEAR(a.time_s, fired_s + a.tof_s, 0.6e-6);  // written to the microsecond
  }
}

TEST(Synthetic, TimeWalkFollowsTheTrueAmplitude) {
  Scenario s = without_noise(hall_scenario());
  test::add_attenuation(s);
  s.log_amplitude = true;
  const World w = must(simulate(s, 2));
  const AttenuationModel m = *w.truth.attenuation;
  const double c = w.truth.speed_mps(21.0);
  for (const Arrival& a : w.run.arrivals) {
    const double d = distance_m(w, a, truth_at(w.run, a.time_s));
    const double volts = m.amplitude_1m_v / d * std::exp(-m.absorption_np_per_m * d);
    EXPECT_NEAR(a.amplitude_v, volts, 1e-12);
    EXPECT_GT(volts, m.threshold_v);
    const double walk_s = -m.rise_time_s * std::log(1 - m.threshold_v / volts);
    EXPECT_NEAR(a.tof_s, d / c + w.truth.beacons[a.beacon.index()].delay_s + walk_s, 1e-14);
  }
}

TEST(Synthetic, DirectionalReceiversHearLessOffTheirAxes) {
  Scenario s = without_noise(hall_scenario());
  test::add_attenuation(s);
  s.log_amplitude = true;
  s.hearing_half_angle_rad = 3.2;
  s.site.attenuation->half_power_angle_rad = {0.4, 0.05};
  s.site.attenuation->saturation_v = 0.5;
  const World w = must(simulate(s, 2));
  const AttenuationModel m = *w.truth.attenuation;
  EXPECT_NE(m.half_power_angle_rad, 0.4) << "drawn";
  int off_axis = 0, saturated = 0;
  for (const Arrival& a : w.run.arrivals) {
    const Pose T = truth_at(w.run, a.time_s);
    const DeploymentReceiver& r = w.truth.receivers[a.receiver.index()];
    const Eigen::Vector3d to = w.truth.beacons[a.beacon.index()].position_m - T * r.position_m;
    const double half = std::acos((T.rotation * *r.axis).dot(to) / to.norm()) / 2,
                 half_power = m.half_power_angle_rad / 2;
    const double gain = std::pow(std::cos(half), -std::log(2.0) / (2 * std::log(std::cos(half_power))));
    const double volts = gain * m.amplitude_1m_v / to.norm() * std::exp(-m.absorption_np_per_m * to.norm());
    EXPECT_NEAR(a.amplitude_v, std::min(volts, 0.5), 1e-11);
    EXPECT_GT(volts, m.threshold_v);
    off_axis += gain < 0.5;
    saturated += volts > 0.5;
  }
  EXPECT_GT(off_axis, 100);
  EXPECT_GT(saturated, 5);
}

TEST(Synthetic, EachEpochHasItsCycleOffset) {
  Scenario s = without_noise(hall_scenario());
  s.site.timing.clock = Clock::kCycleOffset;
  s.cycle_offset_s = {-0.02, 0.03};
  const World w = must(simulate(s, 3));
  std::map<std::int64_t, double> offset_s;
  for (const Arrival& a : w.run.arrivals) {
    const double rest_s = a.tof_s - w.truth.beacons[a.beacon.index()].delay_s -
                          distance_m(w, a, truth_at(w.run, a.time_s)) / w.truth.speed_mps(21.0);
    const auto [it, is_new] = offset_s.emplace(a.epoch, rest_s);
    EXPECT_NEAR(rest_s, it->second, 1e-14);
    EXPECT_GE(rest_s, -0.02 - 1e-14);
    EXPECT_LE(rest_s, 0.03 + 1e-14);
  }
  EXPECT_GT(offset_s.size(), 100u);
  EXPECT_NE(offset_s[0], offset_s[1]);
}

TEST(Synthetic, DriveHearsAtThePoseOfTheInstant) {
  Scenario s = without_noise(drive_scenario(30.0));
  s.path.odometry_period_s = 0.005;  // truth at the simulation's own sampling: linear in between
  s.path.speed_mps = 5.0;  // 0.15 m between firing and hearing: a pose at the wrong instant would show
  const World w = must(simulate(s, 4));
  ASSERT_GT(w.run.arrivals.size(), 500u);
  for (const Arrival& a : w.run.arrivals) {
    const double d = distance_m(w, a, truth_at(w.run, a.time_s));
    // time_s is rounded to the microsecond: 2.5 um, 8 ns.
    EXPECT_NEAR(a.tof_s, d / w.truth.speed_mps(21.0) + w.truth.beacons[a.beacon.index()].delay_s, 1e-8);
  }
}

TEST(Synthetic, TwoWayDriveAsksAndHearsFromDifferentPlaces) {
  Scenario s = without_noise(drive_scenario(30.0));
  s.site.timing.ranging = Ranging::kTwoWay;
  s.site.timing.turnaround_s = 2e-3;
  s.path.odometry_period_s = 0.005;
  s.path.speed_mps = 5.0;
  s.path.slot_s = 0.2;
  const World w = must(simulate(s, 4));
  ASSERT_GT(w.run.arrivals.size(), 100u);
  for (const Arrival& a : w.run.arrivals) {
    const double asked_s = a.time_s - a.tof_s;
    const double path_m =
        distance_m(w, a, truth_at(w.run, a.time_s)) + distance_m(w, a, truth_at(w.run, asked_s));
    EXPECT_NEAR(a.tof_s, path_m / w.truth.speed_mps(21.0) + 2e-3 + w.truth.beacons[a.beacon.index()].delay_s,
                3e-8);
    const double slots = (asked_s - 10.0) / 0.2;
    EXPECT_NEAR(slots - std::floor(slots), 0.26, 1e-4);
  }
}

TEST(Synthetic, OdometryInSpaceIntegratesToTruth) {
  Scenario s = without_noise(drive_scenario(60.0));
  s.site.motion = Motion::kSpatial;
  s.log_odometry = true;
  const World w = must(simulate(s, 6));
  ASSERT_EQ(w.run.odometry.size(), w.run.truth.size());
  Pose T = w.run.truth[0].T_map_vehicle;
  bool leaves_the_plane = false;
  for (std::size_t i = 1; i < w.run.odometry.size(); ++i) {
    T = T * w.run.odometry[i].pose();
    leaves_the_plane = leaves_the_plane || !w.run.odometry[i].is_planar();
    EXPECT_NEAR((T.translation_m - w.run.truth[i].T_map_vehicle.translation_m).norm(), 0.0, 1e-11);
    EXPECT_NEAR(T.rotation.angularDistance(w.run.truth[i].T_map_vehicle.rotation), 0.0, 1e-7);
  }
  EXPECT_TRUE(leaves_the_plane);
}

TEST(Synthetic, OdometryIntegratesToTruth) {
  const World w = must(simulate(without_noise(drive_scenario(120.0)), 5));
  ASSERT_EQ(w.run.odometry.size(), w.run.truth.size());
  Pose T = w.run.truth[0].T_map_vehicle;
  EXPECT_EQ(w.run.odometry[0].dx_m, 0.0);
  double length_m = 0.0;
  for (std::size_t i = 1; i < w.run.odometry.size(); ++i) {
    const OdometryStep& step = w.run.odometry[i];
    T = T * Pose::planar(step.dx_m, step.dy_m, step.dheading_rad);
    EXPECT_NEAR((T.translation_m - w.run.truth[i].T_map_vehicle.translation_m).norm(), 0.0, 1e-11);
    EXPECT_NEAR(wrap_angle(T.heading_rad() - w.run.truth[i].T_map_vehicle.heading_rad()), 0.0, 1e-11);
    length_m += std::hypot(step.dx_m, step.dy_m);
  }
  EXPECT_NEAR(length_m, 0.6 * 120,
              0.01);  // speed times time; chords are shorter than arcs by 5e-5 of their length at most
}

TEST(Synthetic, DriveGoesFromGoalToGoalWithinTheHall) {
  Scenario s = drive_scenario(120.0);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const TimedPose& p : must(simulate(s, seed)).run.truth) {
      ASSERT_TRUE((p.T_map_vehicle.translation_m.array() >= 0).all()) << seed;
      ASSERT_TRUE(p.T_map_vehicle.translation_m.x() <= 20 && p.T_map_vehicle.translation_m.y() <= 12) << seed;
    }
  }
  s.path.waypoints_m = {{4, 6}, {16, 6}};
  int visits = 0;
  for (const TimedPose& p : must(simulate(s, 1)).run.truth) {
    const Vector2d goal = s.path.waypoints_m[static_cast<std::size_t>(visits + 1) % 2];
    visits += (p.T_map_vehicle.translation_m.head<2>() - goal).norm() < 2.2;
  }
  // 72 m; 12 m to the first goal less the radius at which it counts as reached, then as much and a turn of
  // 0.86 m radius each.
  EXPECT_GE(visits, 5);
}

TEST(Synthetic, TruthCoversEveryArrival) {
  Scenario hurried = hall_scenario(), dense = drive_scenario(60.0);
  hurried.path.epoch_period_s = 0.51;  // the next stop begins right after the last arrivals
  dense.path.slot_s = 0.005;           // some arrivals come after the last odometry row
  for (const Scenario& s : {hall_scenario(), hurried, drive_scenario(60.0), dense}) {
    const World w = must(simulate(s, 6));
    for (const MeasurementLog* log : {&w.run, &w.heldout}) {
      for (std::size_t i = 1; i < log->truth.size(); ++i)
        ASSERT_GT(log->truth[i].time_s, log->truth[i - 1].time_s);
      for (std::size_t i = 1; i < log->arrivals.size(); ++i)
        ASSERT_GE(log->arrivals[i].time_s, log->arrivals[i - 1].time_s);
      for (const Arrival& a : log->arrivals) {
        const auto after = std::find_if(log->truth.begin(), log->truth.end(),
                                        [&](const TimedPose& p) { return p.time_s > a.time_s; });
        ASSERT_TRUE(after != log->truth.begin() && after != log->truth.end());
        EXPECT_LT(after->time_s - std::prev(after)->time_s, 0.0501);
        const bool standing =
            after->T_map_vehicle.translation_m == std::prev(after)->T_map_vehicle.translation_m;
        EXPECT_TRUE(standing || a.epoch == kNoEpoch);
      }
    }
  }
}

TEST(Synthetic, ReceiversHearInTheirConeAndRangeAndNowhereElse) {
  const Scenario s = hall_scenario();
  const World w = must(simulate(s, 9));
  std::set<std::tuple<std::int64_t, int, int>> heard;
  for (const Arrival& a : w.run.arrivals) heard.insert({a.epoch, a.beacon.value, a.receiver.value});
  std::map<std::int64_t, Pose> stops;
  for (const TimedPose& p : w.run.truth)
    stops.emplace(static_cast<std::int64_t>((p.time_s - 10.0) / 5.0 + 1e-6), p.T_map_vehicle);
  ASSERT_EQ(stops.size(), 120u);
  for (const auto& [epoch, T] : stops) {
    for (int b = 0; b < 8; ++b) {
      for (int r = 0; r < 8; ++r) {
        const Vector3d towards =
            w.truth.beacons[static_cast<std::size_t>(b)].position_m -
            receiver_in_map(T, w.truth.receivers[static_cast<std::size_t>(r)].position_m);
        const double out = T.heading_rad() + r * M_PI / 4;
        const double angle =
            std::acos((towards.x() * std::cos(out) + towards.y() * std::sin(out)) / towards.norm());
        if (std::abs(angle - 1.18) < 1e-9 || std::abs(towards.norm() - 12.0) < 1e-9)
          continue;  // on the very edge
        EXPECT_EQ(heard.count({epoch, b, r}), angle < 1.18 && towards.norm() < 12.0 ? 1u : 0u)
            << epoch << " B" << b << " r" << r;
      }
    }
  }
}

TEST(Synthetic, TemperatureColumnRisesAndSpeedFollows) {
  Scenario s = without_noise(hall_scenario());
  s.warming_degC = 8.0;
  const World w = must(simulate(s, 10));
  EXPECT_LT(w.run.arrivals.front().temperature_degC, 17.1);
  EXPECT_GT(w.run.arrivals.back().temperature_degC, 24.9);
  for (const Arrival& a : w.run.arrivals) {
    const double d = distance_m(w, a, truth_at(w.run, a.time_s));
    EXPECT_NEAR(a.tof_s,
                d / w.truth.speed_mps(a.temperature_degC) + w.truth.beacons[a.beacon.index()].delay_s, 1e-15);
  }
}

TEST(Synthetic, CounterCountsInItsQuantum) {
  Scenario s = hall_scenario();
  for (double quantum_s : {1e-6, 5e-8, 3e-7}) {
    s.quantum_s = quantum_s;
    for (const Arrival& a : must(simulate(s, 11)).run.arrivals) {
      EXPECT_NEAR(a.tof_s / quantum_s, std::round(a.tof_s / quantum_s), 1e-8);
    }
  }
}

TEST(Synthetic, SpatialMotionTiltsAndStillFollowsTheEquation) {
  for (Scenario s : {without_noise(hall_scenario()), without_noise(drive_scenario(20.0))}) {
    s.site.motion = Motion::kSpatial;
    s.path.odometry_period_s = 0.005;
    s.log_poses = true;
    const World w = must(simulate(s, 12));
    EXPECT_TRUE(w.run.odometry.empty());  // of which nothing is said
    double tilt_rad = 0.0;
    for (std::size_t i = 0; i < w.run.arrivals.size(); i += 7) {
      const Arrival& a = w.run.arrivals[i];
      auto after = std::find_if(w.run.truth.begin(), w.run.truth.end(),
                                [&](const TimedPose& p) { return p.time_s > a.time_s; });
      const TimedPose &low = *std::prev(after), &high = *after;
      const double alpha = (a.time_s - low.time_s) / (high.time_s - low.time_s);
      const Pose T{(1 - alpha) * low.T_map_vehicle.translation_m + alpha * high.T_map_vehicle.translation_m,
                   low.T_map_vehicle.rotation.slerp(alpha, high.T_map_vehicle.rotation)};
      tilt_rad = std::max(tilt_rad, std::acos(std::min(1.0, (T.rotation * Vector3d::UnitZ()).z())));
      const double d = (T.rotation.toRotationMatrix() * w.truth.receivers[a.receiver.index()].position_m +
                        T.translation_m - w.truth.beacons[a.beacon.index()].position_m)
                           .norm();
      EXPECT_NEAR(a.tof_s, d / w.truth.speed_mps(21.0) + w.truth.beacons[a.beacon.index()].delay_s, 5e-9);
    }
    EXPECT_GT(tilt_rad, 0.03);
    ASSERT_FALSE(w.run.poses.empty());
    EXPECT_LT(
        (w.run.poses[3].T_map_vehicle.translation_m - w.run.truth[3].T_map_vehicle.translation_m).norm(),
        1e-15);
  }
}

TEST(Synthetic, WaypointsAreFollowedEvenly) {
  Scenario s = hall_scenario();
  s.path = {.kind = PathKind::kWaypoints, .epochs = 5, .waypoints_m = {{2, 2}, {8, 2}, {8, 4}}};
  const World w = must(simulate(s, 1));
  const std::vector<Vector2d> expected = {{2, 2}, {4, 2}, {6, 2}, {8, 2}, {8, 4}};
  for (std::size_t k = 0; k < 5; ++k) {
    const Pose T = truth_at(w.run, 10.0 + 5.0 * static_cast<double>(k) + 0.01);
    EXPECT_LT((T.translation_m.head<2>() - expected[k]).norm(), 1e-12) << k;
    EXPECT_NEAR(T.heading_rad(), k < 4 ? 0.0 : M_PI / 2, 1e-12);
  }
}

TEST(Synthetic, StationsAreKeptRoundAndRound) {
  Scenario s = hall_scenario();
  s.path = {.kind = PathKind::kStations, .epochs = 3, .stations = {{2, 3, 0.5}, {8, 2, -2.0}}};
  const World w = must(simulate(s, 1));
  for (std::size_t k = 0; k < 3; ++k) {
    const Pose T = truth_at(w.run, 10.0 + 5.0 * static_cast<double>(k) + 0.01);
    EXPECT_LT((T.translation_m.head<2>() - s.path.stations[k % 2].head<2>()).norm(), 1e-12) << k;
    EXPECT_NEAR(T.heading_rad(), s.path.stations[k % 2].z(), 1e-12);
  }
}

TEST(Synthetic, TrueDeploymentPredictsTheArrivals) {
  Scenario s = without_noise(hall_scenario());
  s.site.timing.delay_per = {.beacon = true, .receiver = true, .site = true};
  const World w = must(simulate(s, 13));
  EXPECT_EQ(w.truth.statistics.arrivals, w.run.arrivals.size());
  EXPECT_EQ(w.truth.datum.control_points, (std::vector<std::string>{"B0", "B3", "B6"}));
  EXPECT_EQ(w.truth.beacons[3].status, BeaconStatus::kControlPoint);
  EXPECT_EQ(w.truth.beacons[4].status, BeaconStatus::kCalibrated);
  // The prior mean is part of the beacons' delays; receivers and site scatter about zero.
  for (const DeploymentReceiver& r : w.truth.receivers) EXPECT_LE(std::abs(r.delay_s), 5e-5);
  for (const DeploymentBeacon& b : w.truth.beacons) EXPECT_TRUE(b.delay_s >= 0 && b.delay_s <= 2e-4);
  const SharedState state = shared_state(w.truth);
  for (const Arrival& a : w.run.arrivals) {
    const double d = distance_m(w, a, truth_at(w.run, a.time_s));
    EXPECT_NEAR(a.tof_s, d / w.truth.speed_mps(21.0) + state.delay_s(a.beacon, a.receiver), 1e-15);
  }
}

}  // namespace synthetic_test
}  // namespace octant
