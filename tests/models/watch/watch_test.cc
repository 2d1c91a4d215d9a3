// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/watch.h"

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "models/physics/measurement.h"
#include "models/simulator/random.h"
#include "tests/support/allocation_count.h"
#include "tests/support/worlds.h"

namespace octant {
namespace watch_test {

/// The calibrated hall, and a robot that stops all over it. Faults are in `truth` only.
class Rounds {
 public:
  explicit Rounds(std::uint64_t seed) : draws_(seed, 7) {
    Scenario s = test::hall_scenario();
    s.path.epochs = s.heldout_path.epochs = 1;
    deployment = test::must(simulate(s, 1)).truth;
    deployment.speed_sigma_mps = 0.05;
    for (DeploymentBeacon& b : deployment.beacons) {
      if (b.status == BeaconStatus::kCalibrated) b.covariance_m2 = 4e-6 * Eigen::Matrix3d::Identity();
      b.delay_sigma_s = 3e-6;
    }
    truth = deployment;
  }

  /// The arrivals of one stop, from the receivers that face a beacon within 12 m; the fix is the pose to a
  /// centimetre.
  void stop() {
    time_s += 1.0;
    const Pose at = planar_pose(draws_.uniform(2, 18), draws_.uniform(2, 10), draws_.uniform(-3.1, 3.1));
    const SharedState state = shared_state(truth);
    arrivals.clear();
    for (std::size_t b = 0; b < truth.beacons.size(); ++b)
      for (std::size_t r = 0; r < truth.receivers.size(); ++r) {
        const Eigen::Vector3d to = state.beacon_p_map_m[b] - at * state.receiver_p_vehicle_m[r];
        const Eigen::Vector3d axis =
            truth.receivers[r].axis ? at.rotation * *truth.receivers[r].axis : to.normalized();
        if (to.norm() > 12.0 || axis.dot(to.normalized()) < 0.4) continue;
        PathInput in = path_of(state, BeaconId(b), ReceiverId(r),
                               truth.speed_mps(truth.medium.temperature_degC) + faster_air_mps);
        in.T_map_vehicle = &at;
        Arrival a;
        a.time_s = time_s;
        a.beacon = BeaconId(b);
        a.receiver = ReceiverId(r);
        a.vehicle = VehicleId(0);
        a.tof_s = predict_arrival_value(in).tof_s + noise_factor * truth.noise.tof_sigma_s * draws_.normal();
        if (draws_.uniform() < echo_share) a.tof_s += draws_.log_uniform(1e-4, 3e-3);
        arrivals.push_back(a);
      }
    fix.status = arrivals.size() >= 4 ? FixStatus::kOk : FixStatus::kTooFewArrivals;
    fix.time_s = time_s;
    fix.rejections.clear();
    fix.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    fix.T_map_vehicle = at;
    fix.T_map_vehicle.translation_m += 0.01 * Eigen::Vector3d(draws_.normal(), draws_.normal(), 0);
  }

  Deployment deployment, truth;
  std::vector<Arrival> arrivals;
  Fix fix;
  double time_s = 0.0, faster_air_mps = 0.0, noise_factor = 1.0, echo_share = 0.0;

 private:
  static Pose planar_pose(double x_m, double y_m, double heading_rad) {
    Pose pose;
    pose.translation_m = {x_m, y_m, 0.0};
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()));
    return pose;
  }
  Random draws_;
};

std::optional<WatchAlarm> first_alarm(Watch& watch, Rounds& rounds, int stops) {
  for (int i = 0; i < stops; ++i) {
    rounds.stop();
    if (auto alarm = watch.observe_epoch(rounds.arrivals, rounds.fix)) return alarm;
  }
  return std::nullopt;
}

/// False alarms of an hour, where the stated rate allows one in a thousand stops.
int false_alarms(Rounds& rounds, int stops) {
  WatchOptions options;
  const double stops_a_month = 30.0 * 24 * 3600;
  options.false_alarms_a_month = stops_a_month / 1000.0;
  Watch watch(rounds.deployment, options);
  int alarms = 0;
  for (int i = 0; i < stops; ++i) {
    rounds.stop();
    if (!watch.observe_epoch(rounds.arrivals, rounds.fix)) continue;
    ++alarms;
    watch.restart();
  }
  return alarms;
}

// The stated rate is an upper bound: of 4 expected at most, beyond 13 is less than one in ten thousand
// (Poisson).
TEST(Watch, FalseAlarmsAreAtMostAsFrequentAsStated) {
  Rounds rounds(1);
  EXPECT_LE(false_alarms(rounds, 4'000), 13);
}

// A beacon late by somewhat less than half of what matters.
TEST(Watch, WhatIsLetPassDoesNotAlarm) {
  Rounds rounds(2);
  rounds.truth.beacons[4].delay_s += 0.4 * 0.03 / 345.0;
  Watch watch(rounds.deployment, {.matter_m = 0.03});
  EXPECT_FALSE(first_alarm(watch, rounds, 2'000));
}

// A beacon calibrated with less than half the amplitude of the others is late for its distance, which is not
// a change.
TEST(Watch, LoudnessThatTheCalibrationKnowsAccusesNobody) {
  Rounds rounds(4);
  for (Deployment* d : {&rounds.deployment, &rounds.truth}) {
    d->attenuation = AttenuationModel{
        .amplitude_1m_v = 1.0, .absorption_np_per_m = 0.05, .threshold_v = 0.01, .rise_time_s = 800e-6};
    d->beacons[2].gain = 0.4;
  }
  EXPECT_LE(false_alarms(rounds, 4'000), 13);  // of 4 expected at most; beyond 13 is one in ten thousand
}

TEST(Watch, FasterAirAccusesNobody) {
  Rounds rounds(3);
  rounds.faster_air_mps = 0.6;
  EXPECT_LE(false_alarms(rounds, 2'000), 9);  // of 2 expected at most
}

TEST(Watch, EchoesAccuseNobody) {
  Rounds rounds(4);
  rounds.echo_share = 0.05;
  Watch watch(rounds.deployment);
  EXPECT_FALSE(first_alarm(watch, rounds, 2'000));
}

struct Change {
  const char* name;
  WatchKind kind;
  std::function<void(Rounds&)> apply;
  double size_m;
};

// Forty changes, found within some minutes and named.
TEST(Watch, ChangesAreFoundAndNamed) {
  const Change changes[] = {
      {"late", WatchKind::kBeaconLate, [](Rounds& r) { r.truth.beacons[4].delay_s += 0.09 / 345.0; }, 0.09},
      {"early", WatchKind::kBeaconLate, [](Rounds& r) { r.truth.beacons[4].delay_s -= 0.09 / 345.0; }, -0.09},
      {"moved east", WatchKind::kBeaconMoved, [](Rounds& r) { r.truth.beacons[4].position_m.x() += 0.09; },
       0.09},
      {"moved south", WatchKind::kBeaconMoved, [](Rounds& r) { r.truth.beacons[4].position_m.y() -= 0.09; },
       -0.09}};
  int found = 0, who = 0, what = 0, tried = 0;
  double stops = 0.0;
  for (const Change& change : changes)
    for (std::uint64_t seed = 1; seed <= 10; ++seed, ++tried) {
      Rounds rounds(100 + seed);
      change.apply(rounds);
      Watch watch(rounds.deployment);
      const auto alarm = first_alarm(watch, rounds, 300);
      if (!alarm) continue;
      ++found;
      stops += alarm->time_s;
      const bool beacon = alarm->kind == WatchKind::kBeaconLate || alarm->kind == WatchKind::kBeaconMoved;
      who += beacon && alarm->beacon == BeaconId(4);
      what += alarm->kind == change.kind && alarm->size_m * change.size_m > 0;
    }
  RecordProperty("found", found);
  RecordProperty("named", who);
  RecordProperty("kind", what);
  std::cout << "found " << found << " of " << tried << ", named " << who << ", kind " << what << ", "
            << stops / std::max(1, found) << " stops on average\n";
  EXPECT_GE(found, 0.97 * tried);
  EXPECT_GE(who, 0.95 * tried);
  EXPECT_GE(what, 0.8 * tried);
}

TEST(Watch, WhoeverIsToldIsOutAndTheNextIsFoundToo) {
  Rounds rounds(5);
  rounds.truth.beacons[4].delay_s += 0.2 / 345.0;
  rounds.truth.receivers[2].delay_s += 0.1 / 345.0;
  Watch watch(rounds.deployment);
  const auto first = first_alarm(watch, rounds, 600);
  ASSERT_TRUE(first);
  const auto second = first_alarm(watch, rounds, 600);
  ASSERT_TRUE(second);
  EXPECT_TRUE(watch.is_out(BeaconId(4)));
  EXPECT_TRUE(watch.is_out(ReceiverId(2)));
  EXPECT_FALSE(first_alarm(watch, rounds, 300));
  watch.restart();
  EXPECT_FALSE(watch.is_out(BeaconId(4)));
}

// Arrivals that the fix rejects speak too: a beacon that moved far is never used again.
TEST(Watch, RejectedArrivalsCount) {
  Rounds rounds(6);
  rounds.truth.beacons[4].delay_s += 1.0 / 345.0;
  Watch watch(rounds.deployment);
  std::optional<WatchAlarm> alarm;
  for (int i = 0; i < 200 && !alarm; ++i) {
    rounds.stop();
    for (const Arrival& a : rounds.arrivals)
      rounds.fix.rejections.push_back(a.beacon == BeaconId(4) ? Rejection::kLate : Rejection::kUsed);
    alarm = watch.observe_epoch(rounds.arrivals, rounds.fix);
  }
  ASSERT_TRUE(alarm);
  EXPECT_EQ(alarm->beacon, BeaconId(4));
  EXPECT_EQ(alarm->kind, WatchKind::kBeaconLate);
}

/// The hall and a robot that drives around in it; the beacons take turns.
class Drive {
 public:
  explicit Drive(std::uint64_t seed)
      : rounds_(seed), deployment(rounds_.deployment), truth(deployment), draws_(seed, 8) {
    for (double& phase : phases_) phase = draws_.uniform(0.0, 6.3);
  }

  /// Moves on for some seconds, and adds the alarms.
  void go_on(Watch& watch, double seconds) {
    for (const double until_s = time_s + seconds; time_s < until_s; ++firing_) {
      if (!watch.is_following()) watch.start(pose(time_s), 1e-4 * Eigen::Matrix3d::Identity());
      const Pose moved = pose(time_s).inverse() * pose(time_s + kSlot_s);
      time_s += kSlot_s;
      const double sigma_m = 0.02 * std::sqrt(moved.translation_m.norm());
      OdometryObservation step;
      step.distance_sigma_m = step.heading_sigma_rad = sigma_m;
      step.T_before_after = moved * Pose::planar(sigma_m * draws_.normal(), sigma_m * draws_.normal(),
                                                 sigma_m * draws_.normal());
      watch.move(step);
      for (const Arrival& a : arrivals(firing_ % truth.beacons.size()))
        if (const auto alarm = watch.observe_arrival(a)) alarms.push_back(*alarm);
    }
  }

 private:
  static constexpr double kSlot_s = 0.05;

 public:
  double time_s = 0.0, multipath_m = 0.0;
  std::size_t silent = 1000;
  std::vector<WatchAlarm> alarms;

 private:
  static Pose pose(double t) {
    return Pose::planar(10 + 7 * std::sin(0.11 * t), 6 + 3.5 * std::sin(0.173 * t + 1.0),
                        1.5 * std::sin(0.2 * t));
  }
  std::vector<Arrival> arrivals(std::size_t beacon) {
    std::vector<Arrival> out;
    if (beacon == silent) return out;
    const SharedState state = shared_state(truth);
    const Pose at = pose(time_s);
    // An error of the place, the same for all receivers.
    const double phase = phases_[beacon % phases_.size()],
                 multipath = multipath_m * (std::sin(2.0 * at.translation_m.x() + phase) +
                                            std::sin(1.6 * at.translation_m.y() - phase));
    for (std::size_t r = 0; r < truth.receivers.size(); ++r) {
      if ((state.beacon_p_map_m[beacon] - at * state.receiver_p_vehicle_m[r]).norm() > 12.0) continue;
      PathInput in =
          path_of(state, BeaconId(beacon), ReceiverId(r), truth.speed_mps(truth.medium.temperature_degC));
      in.T_map_vehicle = &at;
      out.push_back({.time_s = time_s,
                     .tof_s = predict_arrival_value(in).tof_s + multipath / 345.0 +
                              truth.noise.tof_sigma_s * draws_.normal(),
                     .beacon = BeaconId(beacon),
                     .receiver = ReceiverId(r),
                     .vehicle = VehicleId(0)});
    }
    return out;
  }

  Rounds rounds_;

 public:
  Deployment deployment, truth;

 private:
  Random draws_;
  std::array<double, 16> phases_{};
  std::size_t firing_ = 0;
};

TEST(WatchedDrive, WithoutAChangeThereIsNoAlarm) {
  Drive drive(11);
  Watch watch(drive.deployment);
  drive.go_on(watch, 300.0);
  EXPECT_TRUE(drive.alarms.empty());
}

TEST(WatchedDrive, AMovedBeaconIsNamedWithItsShiftAndNoOther) {
  Drive drive(12);
  Watch watch(drive.deployment);
  drive.go_on(watch, 60.0);
  drive.truth.beacons[4].position_m += Eigen::Vector3d(0.03, -0.04, 0.0);
  drive.go_on(watch, 250.0);
  ASSERT_EQ(drive.alarms.size(), 1u);
  const WatchAlarm& alarm = drive.alarms[0];
  EXPECT_EQ(alarm.beacon, BeaconId(4));
  EXPECT_EQ(alarm.kind, WatchKind::kBeaconMoved);
  EXPECT_NEAR(alarm.shift_m.x(), 0.03, 0.01);
  EXPECT_NEAR(alarm.shift_m.y(), -0.04, 0.01);
  EXPECT_LT(alarm.time_s, 60.0 + 120.0);
  EXPECT_NEAR(alarm.since_s, 60.0, 8.0) << "a block of the drive";
  EXPECT_TRUE(watch.is_out(BeaconId(4)));
}

/// The move changes most paths by less than the 15 mm that are tolerated, but not the position.
TEST(WatchedDrive, AMoveAcrossThePathsIsNamed) {
  Drive drive(12);
  Watch watch(drive.deployment, {.matter_m = 0.03});
  drive.go_on(watch, 60.0);
  const Eigen::Vector3d to_middle = Eigen::Vector3d(10, 6, 0) - drive.truth.beacons[4].position_m;
  drive.truth.beacons[4].position_m +=
      0.019 * Eigen::Vector3d(-to_middle.y(), to_middle.x(), 0.0).normalized();
  drive.go_on(watch, 120.0);
  ASSERT_EQ(drive.alarms.size(), 1u);
  EXPECT_EQ(drive.alarms[0].beacon, BeaconId(4));
}

TEST(WatchedDrive, AReplacedBeaconIsLateAndTheNextChangeIsFoundToo) {
  Drive drive(13);
  Watch watch(drive.deployment);
  drive.go_on(watch, 60.0);
  drive.truth.beacons[2].delay_s += 1.5e-4;
  drive.go_on(watch, 120.0);
  ASSERT_EQ(drive.alarms.size(), 1u);
  EXPECT_EQ(drive.alarms[0].beacon, BeaconId(2));
  EXPECT_EQ(drive.alarms[0].kind, WatchKind::kBeaconLate);
  EXPECT_NEAR(drive.alarms[0].size_m, 1.5e-4 * 345.0, 0.01)
      << drive.alarms[0].shift_m.transpose() << " at " << drive.alarms[0].time_s << " sigma "
      << drive.alarms[0].sigma_m;
  drive.truth.receivers[3].position_m += Eigen::Vector3d(0.02, 0.01, 0.0);
  drive.go_on(watch, 120.0);
  ASSERT_EQ(drive.alarms.size(), 2u);
  EXPECT_EQ(drive.alarms[1].receiver, ReceiverId(3));
  EXPECT_EQ(drive.alarms[1].kind, WatchKind::kReceiverMoved);
  EXPECT_NEAR(drive.alarms[1].shift_m.x(), 0.02, 0.005);
}

// Two waves of 5 mm at each beacon, which vary within some metres.
TEST(WatchedDrive, MultipathOfThePlaceAccusesNobody) {
  Drive drive(14);
  drive.multipath_m = 0.005;
  Watch watch(drive.deployment);
  drive.go_on(watch, 400.0);
  EXPECT_TRUE(drive.alarms.empty());
}

TEST(WatchedDrive, ADeadBeaconIsSilent) {
  Drive drive(15);
  Watch watch(drive.deployment);
  drive.go_on(watch, 60.0);
  drive.silent = 4;
  drive.go_on(watch, 200.0);
  ASSERT_EQ(drive.alarms.size(), 1u);
  EXPECT_EQ(drive.alarms[0].beacon, BeaconId(4));
  EXPECT_EQ(drive.alarms[0].kind, WatchKind::kBeaconSilent);
  EXPECT_NEAR(drive.alarms[0].since_s, 60.0, 20.0) << "where it was last within reach";
}

TEST(Watch, AllocatesNothingAndBearsNonsense) {
  Rounds rounds(9);
  Watch watch(rounds.deployment);
  const PoseCovariance covariance = Eigen::Vector3d(1e-4, 1e-4, 2.5e-5).asDiagonal();
  std::size_t taken = 0;
  for (int i = 0; i < 60; ++i) {
    rounds.stop();
    rounds.arrivals.push_back(rounds.arrivals[0]);
    rounds.arrivals.back().tof_s = NAN;
    rounds.arrivals.push_back(rounds.arrivals[0]);
    rounds.arrivals.back().beacon = BeaconId(77);
    const std::size_t before = test::allocations();
    (void)watch.observe_epoch(rounds.arrivals, rounds.fix);
    watch.start(rounds.fix.T_map_vehicle, covariance);
    watch.move(OdometryObservation{});
    (void)watch.observe_arrival(rounds.arrivals[0]);
    taken += test::allocations() - before;
  }
  EXPECT_EQ(taken, 0u);
  Fix none;
  EXPECT_FALSE(watch.observe_epoch(rounds.arrivals, none));
  EXPECT_FALSE(watch.observe_epoch({}, rounds.fix));
}

}  // namespace watch_test
}  // namespace octant
