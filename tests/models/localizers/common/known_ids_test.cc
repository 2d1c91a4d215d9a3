// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Input of a robot can be wrong, but never causes undefined behaviour: every localizer, the watch and whole
// recordings with unknown ids and impossible numbers. Also run with the sanitizers.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/localizers/binaural/binaural.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/drive/drive_tracker.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/head_tail/head_tail.h"
#include "models/localizers/kleeman/kleeman.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/methods.h"
#include "models/localizers/rail/one_beacon.h"
#include "models/localizers/rail/rail.h"
#include "models/localizers/reflectors/reflectors.h"
#include "models/watch/watch.h"
#include "tests/models/localizers/binaural_world.h"
#include "tests/models/localizers/drive_world.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {
namespace known_ids_test {

/// A hall in which every method can work: eight beacons, a vehicle with a receiver at each end, on a rail.
Deployment hall_for_all() {
  Deployment d = with_receiver(with_receiver(hall(), {0.2, 0.0, 0.3}), {-0.2, 0.0, 0.3});
  d.vehicles[0].rail = Rail{.from_m = {1, 6}, .to_m = {19, 6}};
  d.vehicles[0].motion = MotionPrior{};
  return d;
}

struct NamedLocalizer {
  const char* name;
  std::unique_ptr<Localizer> localizer;
};

std::vector<NamedLocalizer> all_localizers(const Deployment& d) {
  std::vector<NamedLocalizer> all;
  all.push_back({"least_squares", std::make_unique<LeastSquaresLocalizer>(d)});
  all.push_back({"drive_tracker", std::make_unique<DriveTracker>(d, OdometryAccuracy{})});
  all.push_back({"kleeman", std::make_unique<Kleeman>(with_octagon(hall()))});
  all.push_back({"head_tail", std::make_unique<HeadTail>(d)});
  all.push_back({"one_beacon", std::make_unique<OneBeacon>(d)});
  all.push_back({"rail", std::make_unique<RailLocalizer>(d)});
  all.push_back({"reflectors", std::make_unique<Reflectors>(d)});
  all.push_back({"binaural", std::make_unique<Binaural>(two_robots())});
  return all;
}

/// Mostly existing ids, otherwise any 32-bit number.
rc::Gen<std::int32_t> some_id(int count) {
  return rc::gen::weightedOneOf<std::int32_t>(
      {{6, rc::gen::inRange<std::int32_t>(0, count)},
       {1, rc::gen::arbitrary<std::int32_t>()},
       {1, rc::gen::element<std::int32_t>(-1, count, 99, 100000, std::numeric_limits<std::int32_t>::max(),
                                          std::numeric_limits<std::int32_t>::min())}});
}

rc::Gen<double> some_tof() {
  return rc::gen::weightedOneOf<double>(
      {{8, rc::gen::map(rc::gen::inRange(1, 800), [](int i) { return 1e-4 * i; })},
       {1, rc::gen::element(0.0, -1.0, 1e300, std::nan(""), std::numeric_limits<double>::infinity())}});
}

rc::Gen<Arrival> some_arrival() {
  return rc::gen::build<Arrival>(
      rc::gen::set(&Arrival::time_s, rc::gen::map(rc::gen::inRange(0, 4), [](int i) { return 1e-3 * i; })),
      rc::gen::set(&Arrival::tof_s, some_tof()),
      rc::gen::set(&Arrival::beacon, rc::gen::map(some_id(8), [](std::int32_t i) { return BeaconId(i); })),
      rc::gen::set(&Arrival::receiver,
                   rc::gen::map(some_id(2), [](std::int32_t i) { return ReceiverId(i); })),
      rc::gen::set(&Arrival::vehicle, rc::gen::map(some_id(1), [](std::int32_t i) { return VehicleId(i); })),
      rc::gen::set(&Arrival::epoch, rc::gen::just<std::int64_t>(0)),
      rc::gen::set(&Arrival::amplitude_v, rc::gen::element(std::nan(""), 0.5, 1.0)));
}

rc::Gen<Bearing> some_bearing() {
  return rc::gen::build<Bearing>(
      rc::gen::set(&Bearing::bearing_rad,
                   rc::gen::map(rc::gen::inRange(-31, 31), [](int i) { return 0.1 * i; })),
      rc::gen::set(&Bearing::reflector, rc::gen::map(some_id(8), [](std::int32_t i) { return BeaconId(i); })),
      rc::gen::set(&Bearing::vehicle, rc::gen::map(some_id(1), [](std::int32_t i) { return VehicleId(i); })),
      rc::gen::set(&Bearing::epoch, rc::gen::just<std::int64_t>(0)));
}

/// Arrivals in a hall, at a pose, at all receivers.
std::vector<Arrival> perfect_arrivals(const Deployment& d, const Pose& T) {
  std::vector<Arrival> arrivals;
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    for (std::size_t r = 0; r < d.receivers.size(); ++r) {
      Arrival a;
      a.beacon = BeaconId(b);
      a.receiver = ReceiverId(r);
      a.vehicle = VehicleId(0);
      a.epoch = 0;
      a.tof_s = (T * d.receivers[r].position_m - d.beacons[b].position_m).norm() /
                    d.speed_mps(d.medium.temperature_degC) +
                d.beacons[b].delay_s;
      arrivals.push_back(a);
    }
  return arrivals;
}

RC_GTEST_PROP(KnownIds, AnyIdsGiveAFixOrAReason, ()) {
  const Deployment d = hall_for_all();
  const auto arrivals = *rc::gen::container<std::vector<Arrival>>(some_arrival());
  const auto bearings = *rc::gen::container<std::vector<Bearing>>(some_bearing());
  for (const NamedLocalizer& each : all_localizers(d)) {
    for (int again = 0; again < 2; ++again) {  // methods that keep a state have one the second time
      const Fix fix = each.localizer->locate(Observations{arrivals, bearings});
      RC_ASSERT(!fix.ok() || fix.T_map_vehicle.translation_m.allFinite());
      RC_ASSERT(fix.rejections.size() <= std::max(arrivals.size(), bearings.size()));
    }
  }
}

RC_GTEST_PROP(KnownIds, StrangersChangeNothingForTheOthers, ()) {
  const Deployment d = hall_for_all();
  const Pose truth = Pose::planar(12, 8, 0.7);
  const std::vector<Arrival> known = perfect_arrivals(d, truth);
  std::vector<Arrival> all = known;
  std::vector<std::size_t> strange;
  for (const std::int32_t id : *rc::gen::container<std::vector<std::int32_t>>(
           rc::gen::element<std::int32_t>(-1, -7, 8, 99, 100000, 2000000000))) {
    Arrival a = known.front();
    (*rc::gen::arbitrary<bool>() ? a.beacon.value : a.receiver.value) = id;
    if (a.receiver.value == -1 && a.beacon.value == -1) continue;
    all.insert(all.begin() + *rc::gen::inRange<std::ptrdiff_t>(0, std::ssize(all) + 1), a);
  }
  const Fix expected = LeastSquaresLocalizer(d).locate(known), fix = LeastSquaresLocalizer(d).locate(all);
  RC_ASSERT(fix.ok());
  RC_ASSERT(fix.T_map_vehicle.translation_m == expected.T_map_vehicle.translation_m);
  RC_ASSERT(fix.arrivals_used == expected.arrivals_used);
  RC_ASSERT(fix.rejections.size() == all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool stranger = !all[i].beacon.valid() || all[i].beacon.index() >= d.beacons.size() ||
                          !all[i].receiver.valid() || all[i].receiver.index() >= d.receivers.size();
    RC_ASSERT((fix.rejections[i] == Rejection::kUnknownId) == stranger);
  }
}

RC_GTEST_PROP(KnownIds, AWatchLooksAway, ()) {
  const Deployment d = hall_for_all();
  const auto arrivals = *rc::gen::container<std::vector<Arrival>>(some_arrival());
  Watch watch(d);
  Fix fix = LeastSquaresLocalizer(d).locate(arrivals);
  fix.status = FixStatus::kOk;
  fix.rejections.resize(*rc::gen::inRange<std::size_t>(0, 2 * arrivals.size() + 1));
  fix.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  (void)watch.observe_epoch(arrivals, fix);
  watch.start(fix.T_map_vehicle, fix.covariance);
  for (const Arrival& a : arrivals) {
    (void)watch.observe_arrival(a);
    (void)watch.is_out(a.beacon);
    (void)watch.is_out(a.receiver);
  }
}

RC_GTEST_PROP(KnownIds, WholeRecordingsToo, ()) {
  const Deployment d = hall_for_all();
  MeasurementLog log;
  log.has_epochs = *rc::gen::arbitrary<bool>();
  log.arrivals = *rc::gen::container<std::vector<Arrival>>(some_arrival());
  std::stable_sort(log.arrivals.begin(), log.arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.time_s < b.time_s; });
  log.bearings = *rc::gen::container<std::vector<Bearing>>(some_bearing());
  for (const auto& [name, method] : method_names())
    if (method != Method::kLineMap) (void)locate_run(method, d, log);
  (void)LeastSquaresLocalizer(d).locate(log);
  (void)track(log, d);
}

TEST(KnownIds, EachMethodFixesOnWithAStranger) {
  const Deployment d = hall_for_all();
  std::vector<Arrival> arrivals = perfect_arrivals(d, Pose::planar(12, 6, 0.0));
  arrivals[3].receiver = ReceiverId(100000);
  for (const char* name : {"least_squares", "head_tail", "rail"})
    for (const NamedLocalizer& each : all_localizers(d)) {
      if (std::string(name) != each.name) continue;
      const Fix fix = each.localizer->locate(Observations{arrivals, {}});
      EXPECT_TRUE(fix.ok()) << name << ": " << to_string(fix.status);
      EXPECT_NEAR(fix.T_map_vehicle.translation_m.x(), 12, 1e-3) << name;
      EXPECT_EQ(fix.rejections[3], Rejection::kUnknownId) << name;
    }
}

TEST(KnownIds, EachMethodFixesOnBesideAnImpossibleTime) {
  const Deployment d = hall_for_all();
  for (const double tof_s : {1e20, 1e160, -1e160, 1e308, std::numeric_limits<double>::infinity()}) {
    std::vector<Arrival> arrivals = perfect_arrivals(d, Pose::planar(12, 6, 0.0));
    arrivals[3].tof_s = tof_s;
    for (const char* name : {"least_squares", "head_tail", "rail"})
      for (const NamedLocalizer& each : all_localizers(d)) {
        if (std::string(name) != each.name) continue;
        const Fix fix = each.localizer->locate(Observations{arrivals, {}});
        EXPECT_TRUE(fix.ok()) << name << ": " << to_string(fix.status);
        EXPECT_NEAR(fix.T_map_vehicle.translation_m.x(), 12, 1e-3) << name;
        ASSERT_EQ(fix.rejections.size(), arrivals.size()) << name;
        EXPECT_EQ(fix.rejections[3], Rejection::kOutOfRange) << name << ", " << tof_s;
      }
  }
}

/// A tenth of a drive's times, and its last time stamp, are impossible.
TEST(KnownIds, AWholeDriveIsFixedOnBesideImpossibleNumbers) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 40, 1e-5, 1.0, 43);
  for (const double tof_s : {1e20, 1e160, 1e308}) {
    MeasurementLog log = w.log;
    for (std::size_t i = 0; i < log.arrivals.size(); i += 10) log.arrivals[i].tof_s = tof_s;
    log.arrivals.back().time_s = std::nan("");
    const auto fixes = locate_run(Method::kAuto, d, log);
    ASSERT_TRUE(fixes);
    const auto ok = std::count_if(fixes->begin(), fixes->end(), [](const Fix& fix) { return fix.ok(); });
    EXPECT_GT(ok, std::ssize(*fixes) * 9 / 10) << tof_s;
    EXPECT_FALSE(track(log, d).empty()) << tof_s;
  }
}

}  // namespace known_ids_test
}  // namespace octant::test
