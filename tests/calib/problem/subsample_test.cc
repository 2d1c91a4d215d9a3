// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Steps of the subsampling, one by one; for its effect on results see tests/calib/plan/check_test.cc.
#include "calib/problem/subsample.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"
#include "models/trajectory/odometry_noise.h"

namespace octant::test {
namespace subsample_test {

RC_GTEST_PROP(EvenlyChosen, AreAsManyAsTheBudgetAndNowhereFarApart, ()) {
  const auto groups = static_cast<std::size_t>(*rc::gen::inRange(0, 500));
  const auto budget = static_cast<std::size_t>(*rc::gen::inRange(1, 600));
  const std::vector<bool> chosen = calib::evenly_chosen(groups, budget);
  RC_ASSERT(chosen.size() == groups);
  RC_ASSERT(static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), true)) ==
            std::min(groups, budget));
  // Any ceil(groups / n) consecutive groups contain one of n evenly spread ones.
  const std::size_t span =
      groups == 0 ? 0 : (groups + std::min(groups, budget) - 1) / std::min(groups, budget);
  std::size_t since = 0;
  for (std::size_t i = 0; i < groups; ++i) {
    since = chosen[i] ? 0 : since + 1;
    RC_ASSERT(since < std::max<std::size_t>(span, 1));
  }
}

TEST(EvenlyChosen, OfNoBudgetAreNone) {
  const std::vector<bool> chosen = calib::evenly_chosen(7, 0);
  EXPECT_EQ(std::count(chosen.begin(), chosen.end(), true), 0);
}

/// Beacon 0 is received in every group, beacon b in every 3^b-th.
struct Heard {
  std::size_t groups, beacons;
  std::vector<bool> chosen;
  calib::GroupsHearing hearing;

  Heard(std::size_t g, std::size_t b, std::size_t budget)
      : groups(g), beacons(b), chosen(calib::evenly_chosen(g, budget)) {
    hearing.kept.assign(beacons, 0);
    hearing.more.resize(beacons);
    hearing.for_each_heard = [this](std::size_t group, const auto& visit) {
      for (std::size_t beacon = 0; beacon < beacons; ++beacon)
        if (hears(group, beacon)) visit(beacon);
    };
    for (std::size_t group = 0; group < groups; ++group)
      for (std::size_t beacon = 0; beacon < beacons; ++beacon) {
        if (!hears(group, beacon)) continue;
        if (chosen[group])
          ++hearing.kept[beacon];
        else
          hearing.more[beacon].push_back(group);
      }
  }
  [[nodiscard]] static bool hears(std::size_t group, std::size_t beacon) {
    std::size_t stride = 1;
    for (std::size_t i = 0; i < beacon; ++i) stride *= 3;
    return (group + 1) % stride == 0;
  }
  [[nodiscard]] std::size_t count(std::size_t beacon, bool all) const {
    std::size_t n = 0;
    for (std::size_t g = 0; g < groups; ++g) n += (all || chosen[g]) && hears(g, beacon);
    return n;
  }
};

RC_GTEST_PROP(ChooseMore, GivesEachBeaconWhatItLacksWhereThereIsSo, ()) {
  Heard heard(static_cast<std::size_t>(*rc::gen::inRange(1, 900)), 5,
              static_cast<std::size_t>(*rc::gen::inRange(1, 200)));
  const auto per_beacon = static_cast<std::size_t>(*rc::gen::inRange(0, 60));
  const std::vector<bool> before = heard.chosen;
  calib::choose_more(heard.hearing, per_beacon, heard.chosen);
  for (std::size_t g = 0; g < heard.groups; ++g) RC_ASSERT(!before[g] || heard.chosen[g]);
  for (std::size_t b = 0; b < heard.beacons; ++b) {
    RC_ASSERT(heard.count(b, false) >= std::min(per_beacon, heard.count(b, true)));
    RC_ASSERT(heard.hearing.kept[b] == heard.count(b, false));
  }
  std::size_t added = 0, lacking = 0;
  for (std::size_t g = 0; g < heard.groups; ++g) added += heard.chosen[g] && !before[g];
  for (std::size_t b = 0; b < heard.beacons; ++b) lacking += std::min(per_beacon, heard.count(b, true));
  RC_ASSERT(added <= lacking);  // no more groups than arrivals were lacking
}

/// A drive of some vehicles, a row each 50 ms, turning and rolling as it goes.
std::vector<OdometryStep> rows_of_a_drive(std::size_t rows, int vehicles, bool in_space) {
  Random draws(4);
  std::vector<OdometryStep> out;
  for (std::size_t i = 0; i < rows; ++i)
    for (int v = 0; v < vehicles; ++v) {
      OdometryStep s;
      s.time_s = 0.05 * static_cast<double>(i) + 0.001 * v;
      s.vehicle = VehicleId(v);
      s.dx_m = 0.03 * draws.normal();
      s.dy_m = 0.01 * draws.normal();
      s.dheading_rad = 0.02 * draws.normal();
      if (in_space) {
        s.dz_m = 0.01 * draws.normal();
        s.turn_x_rad = 0.02 * draws.normal();
        s.turn_y_rad = 0.02 * draws.normal();
      }
      out.push_back(s);
    }
  return out;
}

/// Pose of a vehicle at each of its rows, in the frame of its anchor.
std::map<double, Pose> way_of(const std::vector<OdometryStep>& rows, int vehicle) {
  std::map<double, Pose> way;
  Pose T;
  bool anchored = false;
  for (const OdometryStep& s : rows) {
    if (s.vehicle != VehicleId(vehicle)) continue;
    if (anchored) T = T * s.pose();
    anchored = true;
    way[s.time_s] = T;
  }
  return way;
}

TEST(ThinnedOdometry, GoesTheSameWayThroughFewerRows) {
  for (const bool in_space : {false, true}) {
    SCOPED_TRACE(in_space ? "in space" : "in the plane");
    const std::vector<OdometryStep> rows = rows_of_a_drive(4000, 2, in_space);
    const std::vector<std::pair<double, double>> spans = {{10.0, 13.0}, {50.0, 53.0}, {120.0, 123.0}};
    const std::vector<OdometryStep> few = calib::subsampled_odometry(rows, spans);
    EXPECT_LT(few.size(), rows.size() / 3);
    EXPECT_TRUE(std::is_sorted(few.begin(), few.end(), [](const OdometryStep& a, const OdometryStep& b) {
      return a.time_s < b.time_s;
    }));
    for (const int v : {0, 1}) {
      const auto all = way_of(rows, v), some = way_of(few, v);
      EXPECT_EQ(some.begin()->first, all.begin()->first) << "the anchor";
      EXPECT_EQ(some.rbegin()->first, all.rbegin()->first) << "the end";
      for (const auto& [time_s, T] : some) {
        const Pose& want = all.at(time_s);
        EXPECT_LT((T.translation_m - want.translation_m).norm(), 1e-11);  // roundings of 4,000 sums
        EXPECT_LT(T.rotation.angularDistance(want.rotation), 1e-7);       // of which the angle is the root
      }
      // Within a span every row, and the next one on either side.
      for (const auto& [from_s, to_s] : spans) {
        const auto first = std::prev(all.upper_bound(from_s)), last = all.lower_bound(to_s);
        for (auto at = first; at != std::next(last); ++at)
          EXPECT_TRUE(some.contains(at->first)) << at->first << " of vehicle " << v;
      }
    }
  }
}

/// Variances of the end of a path, of its position [m^2] and heading [rad^2], from the variances of each row.
std::pair<double, double> end_variance(const std::vector<OdometryStep>& rows) {
  const OdometryAccuracy accuracy = {.floor_m = 0.0, .floor_rad = 0.0};
  const std::map<double, Pose> way = way_of(rows, 0);
  const Eigen::Vector3d end_m = way.rbegin()->second.translation_m;
  double place_m2 = 0.0, heading_rad2 = 0.0;
  for (auto row = std::next(rows.begin()); row != rows.end(); ++row) {
    const OdometryVariance v = variance_of(*row, accuracy);
    place_m2 +=
        2 * v.distance_m2 + v.heading_rad2 * (end_m - way.at(row->time_s).translation_m).squaredNorm();
    heading_rad2 += v.heading_rad2;
  }
  return {place_m2, heading_rad2};
}

TEST(ThinnedOdometry, AGapOfAnyLengthBecomesAsManySteps) {
  std::vector<std::size_t> sizes;
  for (const std::size_t rows : {20000U, 40000U, 200000U}) {
    const std::vector<OdometryStep> all = rows_of_a_drive(rows, 1, false);
    const double end_s = all.back().time_s;
    const std::vector<OdometryStep> few = calib::subsampled_odometry(all, {{0.0, 3.0}, {end_s - 3.0, end_s}});
    sizes.push_back(few.size());
    // The summed odometry equals that of its rows, although the paths of the steps are not their chords.
    const auto [place_m2, heading_rad2] = end_variance(few);
    const auto [rows_m2, rows_rad2] = end_variance(all);
    EXPECT_NEAR(heading_rad2, rows_rad2, 1e-9 * rows_rad2);
    EXPECT_NEAR(std::sqrt(place_m2), std::sqrt(rows_m2), 0.1 * std::sqrt(rows_m2));
  }
  EXPECT_NEAR(static_cast<double>(sizes[1]), static_cast<double>(sizes[0]), 3.0);
  EXPECT_NEAR(static_cast<double>(sizes[2]), static_cast<double>(sizes[0]), 3.0);
}

TEST(ThinnedOdometry, OfNothingOrOneRowIsThat) {
  EXPECT_TRUE(calib::subsampled_odometry({}, {{0.0, 1.0}}).empty());
  const std::vector<OdometryStep> one = rows_of_a_drive(1, 1, false);
  EXPECT_EQ(calib::subsampled_odometry(one, {}).size(), 1U);
}

TEST(PosesNear, AreThoseWithinAndTheNextOnEitherSide) {
  std::vector<TimedPose> poses;
  for (int i = 0; i < 100; ++i) poses.push_back({static_cast<double>(i), Pose()});
  const auto times = [&](std::vector<std::pair<double, double>> spans) {
    std::set<double> out;
    for (const TimedPose& p : calib::poses_near(poses, spans)) out.insert(p.time_s);
    return out;
  };
  EXPECT_EQ(times({{10.5, 12.5}}), (std::set<double>{10, 11, 12, 13}));
  EXPECT_EQ(times({{10.5, 10.5}, {40.2, 40.3}}), (std::set<double>{10, 11, 40, 41}));
  EXPECT_EQ(times({{-5.0, 0.5}}), (std::set<double>{0, 1}));
  EXPECT_EQ(times({{98.5, 300.0}}), (std::set<double>{98, 99}));
  EXPECT_TRUE(times({}).empty());
  EXPECT_TRUE(calib::poses_near({}, {{0.0, 1.0}}).empty());
}

Site of_beacons(std::size_t count) {
  Site site;
  site.beacons.resize(count);
  return site;
}

/// Instants without epochs and without odometry, at measured poses, with bearings between.
MeasurementLog log_of_instants(int instants) {
  MeasurementLog log;
  log.path = "run";
  log.rows = static_cast<std::size_t>(2 * instants);
  log.temperature_degC = 12.5;
  log.warnings = {"one"};
  log.rejected = {{4, "tof_s is not a number"}};
  for (int i = 0; i < instants; ++i) {
    for (int r = 0; r < 2; ++r) {
      Arrival a;
      a.time_s = i;
      a.beacon = BeaconId(i % 3);
      a.receiver = ReceiverId(r);
      a.vehicle = VehicleId(0);
      a.line = 2 * i + r;
      log.arrivals.push_back(a);
    }
    Bearing b;
    b.time_s = i + (i % 2 == 0 ? 0.0 : 0.5);  // with the instant, or one of its own
    b.reflector = BeaconId(1);
    b.vehicle = VehicleId(0);
    b.line = i;
    log.bearings.push_back(b);
    log.poses.push_back({i - 0.5, Pose()});
  }
  return log;
}

TEST(Thin, KeepsInstantsWholeWithTheirBearingsAndPoses) {
  const MeasurementLog log = log_of_instants(3000);
  const MeasurementLog few = calib::subsample(log, of_beacons(3), {.instants = 90, .per_beacon = 10});
  std::map<double, int> arrivals;
  for (const Arrival& a : few.arrivals) ++arrivals[a.time_s];
  EXPECT_GE(few.arrivals.size(), 2 * 40U);
  EXPECT_LE(arrivals.size(), 90U + 30U);
  std::set<double> bearings;
  for (const Bearing& b : few.bearings) bearings.insert(b.time_s);
  for (const auto& [time_s, count] : arrivals) {
    EXPECT_EQ(count, 2) << time_s;
    if (static_cast<int>(time_s) % 2 == 0) EXPECT_TRUE(bearings.contains(time_s)) << time_s;
    const auto has = [&](double t) {
      return std::any_of(few.poses.begin(), few.poses.end(),
                         [t](const TimedPose& p) { return p.time_s == t; });
    };
    EXPECT_TRUE(has(time_s - 0.5) && (has(time_s + 0.5) || time_s == 2999)) << time_s;
  }
  EXPECT_LT(few.poses.size(), 600U);
  EXPECT_EQ(few.path, "run");
  EXPECT_EQ(few.rows, log.rows);
  EXPECT_EQ(few.temperature_degC, log.temperature_degC);
  EXPECT_EQ(few.warnings, log.warnings);
  EXPECT_EQ(few.rejected.size(), 1U);
}

TEST(Thin, WhatIsSmallComesBackAsItIs) {
  const MeasurementLog log = log_of_instants(20), few = calib::subsample(log, of_beacons(3));
  EXPECT_EQ(few.arrivals.size(), log.arrivals.size());
  EXPECT_EQ(few.bearings.size(), log.bearings.size());
  EXPECT_EQ(few.poses.size(), log.poses.size());
  EXPECT_TRUE(calib::subsample(MeasurementLog(), of_beacons(3)).arrivals.empty());
}

TEST(WithoutLists, KeepsAllElse) {
  MeasurementLog log = log_of_instants(5);
  log.odometry.resize(3);
  log.truth.resize(2);
  log.scans.resize(1);
  log.vehicle = VehicleId(0);
  log.relative_humidity = 0.4;
  log.pressure_pa = 99e3;
  log.has_epochs = true;
  log.pose_accuracy.max_gap_s = 7.0;
  log.odometry_accuracy.floor_m = 3e-3;
  log.truth_accuracy.position_sigma_m = 0.02;
  const MeasurementLog few = calib::without_lists(log);
  EXPECT_TRUE(few.arrivals.empty() && few.bearings.empty() && few.odometry.empty() && few.poses.empty() &&
              few.truth.empty() && few.scans.empty());
  EXPECT_EQ(few.path, log.path);
  EXPECT_EQ(few.vehicle, log.vehicle);
  EXPECT_EQ(few.relative_humidity, log.relative_humidity);
  EXPECT_EQ(few.pressure_pa, log.pressure_pa);
  EXPECT_TRUE(few.has_epochs);
  EXPECT_EQ(few.pose_accuracy.max_gap_s, 7.0);
  EXPECT_EQ(few.odometry_accuracy.floor_m, 3e-3);
  EXPECT_EQ(few.truth_accuracy.position_sigma_m, 0.02);
}

}  // namespace subsample_test
}  // namespace octant::test
