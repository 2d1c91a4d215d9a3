// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/revisit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "calib/revisit/finished.h"
#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/revisit/two_visits.h"

namespace octant::calib {
namespace revisit_test {

TEST(Revisit, NothingChanged) {
  const Revisit found = revisited(two_visits([](Scenario&) {}));
  EXPECT_TRUE(found.comparison.changes.empty());
  EXPECT_GT(found.comparison.p, 1e-3);
  for (const Heard& h : found.beacons) EXPECT_GT(h.used, 0U) << h.name;
  EXPECT_TRUE(found.silent.empty());
}

TEST(Revisit, AMovedBeaconIsFoundAndToldAnew) {
  const TwoVisits visits = two_visits([](Scenario& s) { move(s, kFree, {0.04, -0.01, 0.0}); });
  const Revisit found = revisited(visits);
  ASSERT_EQ(found.comparison.changes.size(), 1U);
  const Change& c = found.comparison.changes[0];
  EXPECT_EQ(c.kind, ChangeKind::kBeaconMoved);
  EXPECT_EQ(c.subject, "B4");
  EXPECT_NEAR(c.size, std::hypot(0.04, 0.01), 4 * c.sigma);
  const Eigen::Vector3d truth = Eigen::Vector3d(16.20, 11.95, 2.505) + Eigen::Vector3d(0.04, -0.01, 0.0);
  const DeploymentBeacon& left = found.as_left.beacons[kFree];
  const Eigen::Vector3d off = left.position_m - truth;
  EXPECT_LT(off.dot(left.covariance_m2.ldlt().solve(off)),
            16.3);  // chi-square with three degrees of freedom, one in a thousand
}

/// The vehicle's poses are free: no other beacon is accused, and the point is no longer fixed.
TEST(Revisit, AKnockedControlPointIsNamedAlone) {
  const Revisit found = revisited(two_visits([](Scenario& s) { move(s, kControlPoint, {0.0, 0.08, 0.0}); }));
  ASSERT_EQ(found.comparison.changes.size(), 1U);
  EXPECT_EQ(found.comparison.changes[0].subject, "B3");
  EXPECT_EQ(found.as_left.beacons[kControlPoint].status, BeaconStatus::kCalibrated);
  EXPECT_GT(found.as_left.beacons[kControlPoint].covariance_m2.trace(), 0.0);
  EXPECT_EQ(found.as_left.datum.control_points, (std::vector<std::string>{"B0", "B6"}));
  EXPECT_EQ(found.as_left.beacons[0].status, BeaconStatus::kControlPoint);
  EXPECT_EQ(found.as_left.beacons[0].covariance_m2.norm(), 0.0);
  EXPECT_EQ(found.as_left.beacons[0].position_m, Eigen::Vector3d(3.90, 0.05, 2.520));
}

TEST(Revisit, ADelayIsNoMove) {
  TwoVisits visits = two_visits([](Scenario&) {});
  for (Arrival& a : visits.second.arrivals)
    if (a.beacon == BeaconId(kFree)) a.tof_s += 80e-6;
  const Revisit found = revisited(visits);
  ASSERT_EQ(found.comparison.changes.size(), 1U);
  EXPECT_EQ(found.comparison.changes[0].kind, ChangeKind::kDelay);
  EXPECT_EQ(found.comparison.changes[0].subject, "B4");
  EXPECT_NEAR(found.comparison.changes[0].size, 80e-6, 4 * found.comparison.changes[0].sigma);
  EXPECT_NEAR(found.beacons[kFree].misfit_s, 80e-6, 2e-5);
  EXPECT_NEAR(found.as_left.beacons[kFree].delay_s, visits.before.beacons[kFree].delay_s + 80e-6, 2e-5);
}

/// Three control points stayed; single steps from an empty set accused two of them.
TEST(Revisit, WhereMostBeaconsMovedControlPointsAreNotAccused) {
  std::vector<std::string> moved;
  const Revisit found = revisited(two_visits([&](Scenario& s) {
    const Eigen::Vector3d by_m[] = {
        {0.1, 0.0, 0.0}, {0.0, 0.1, 0.0}, {-0.1, 0.1, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.1, 0.1}};
    for (std::size_t b = 0; b < s.site.beacons.size(); ++b) {
      if (s.site.beacons[b].is_control_point()) continue;
      move(s, b, by_m[moved.size()]);
      moved.push_back(s.site.beacons[b].name);
    }
  }));
  ASSERT_EQ(moved.size(), 5U);
  std::vector<std::string> named;
  for (const Change& c : found.comparison.changes) named.push_back(c.subject);
  std::sort(named.begin(), named.end());
  EXPECT_EQ(named, moved);
}

TEST(Revisit, TheSameDelayOfAllBeaconsIsOneChange) {
  TwoVisits visits = two_visits([](Scenario&) {});
  for (Arrival& a : visits.second.arrivals) a.tof_s += 50e-6;
  const Revisit found = revisited(visits);
  ASSERT_EQ(found.comparison.changes.size(), 1U);
  const Change& c = found.comparison.changes[0];
  EXPECT_EQ(c.kind, ChangeKind::kDelay);
  EXPECT_EQ(c.subject, "all beacons");
  EXPECT_NEAR(c.size, 50e-6, 4 * c.sigma);
  for (std::size_t b = 0; b < 8; ++b)
    EXPECT_NEAR(found.as_left.beacons[b].delay_s, visits.before.beacons[b].delay_s + 50e-6, 2.5e-5);
}

/// With the earlier parameters only some stops have a pose.
TEST(Revisit, InMuchWarmerAirNoArrivalIsPassedOver) {
  const TwoVisits visits = two_visits([](Scenario& s) { s.site.medium.temperature_degC += 18.0; });
  const Revisit found = revisited(visits);
  EXPECT_TRUE(found.comparison.changes.empty());
  std::size_t counted = 0;
  for (const Heard& h : found.beacons) counted += h.used + h.late + h.early;
  EXPECT_GT(static_cast<double>(counted), 0.97 * static_cast<double>(visits.second.arrivals.size()));
}

TEST(Revisit, ABentReceiverIsNoBeacon) {
  const Revisit found = revisited(
      two_visits([](Scenario& s) { s.site.receivers[1].position_m += Eigen::Vector3d(0.03, 0.0, 0.0); }));
  ASSERT_EQ(found.comparison.changes.size(), 1U);
  EXPECT_EQ(found.comparison.changes[0].kind, ChangeKind::kReceiver);
  EXPECT_EQ(found.comparison.changes[0].subject, "robot/r1");
  EXPECT_NEAR(found.comparison.changes[0].size, 0.03, 5 * found.comparison.changes[0].sigma);
}

TEST(Revisit, ExchangedBeacons) {
  const Revisit found = revisited(
      two_visits([](Scenario& s) { std::swap(s.site.beacons[1].position_m, s.site.beacons[5].position_m); }));
  ASSERT_EQ(found.comparison.changes.size(), 1U);
  EXPECT_EQ(found.comparison.changes[0].kind, ChangeKind::kExchanged);
  EXPECT_EQ(found.comparison.changes[0].subject, "B1, B5");
}

TEST(Revisit, WarmerAirIsNoChangeWhereAThermometerSaysSo) {
  const Revisit found = revisited(two_visits([](Scenario& s) { s.site.medium.temperature_degC += 8.0; }));
  // The rows of the run have no temperature: the speed is then free, and no beacon is accused.
  EXPECT_TRUE(found.comparison.changes.empty());
  EXPECT_FALSE(found.medium.temperature_known);
  EXPECT_NEAR(found.medium.speed_change_mps, 8 * 0.59, 0.5);
  TwoVisits known = two_visits([](Scenario& s) { s.site.medium.temperature_degC += 8.0; });
  known.second.temperature_degC = known.before.medium.temperature_degC + 8.0;
  const Revisit with = revisited(known);
  EXPECT_TRUE(with.comparison.changes.empty());
  EXPECT_TRUE(with.medium.temperature_known);
  EXPECT_NEAR(with.medium.speed_change_mps, 0.0, 0.3);
}

TEST(Revisit, DirtIsAnAmplitudeAndNoMove) {
  Scenario scenario = first_scenario();
  test::add_attenuation(scenario);
  scenario.log_amplitude = true;
  TwoVisits visits = two_visits([](Scenario&) {}, 20, scenario);
  const AttenuationModel& a = *visits.before.attenuation;
  std::vector<Arrival> heard;
  for (Arrival arrival : visits.second.arrivals) {
    if (arrival.beacon == BeaconId(kFree)) {
      // Half the amplitude crosses the threshold later.
      const auto before = time_walk_s(arrival.amplitude_v, a),
                 after = time_walk_s(arrival.amplitude_v / 2, a);
      if (!before || !after) continue;
      arrival.tof_s += *after - *before;
      arrival.amplitude_v /= 2;
    }
    heard.push_back(arrival);
  }
  visits.second.arrivals = std::move(heard);
  const Revisit found = revisited(visits);
  ASSERT_EQ(found.comparison.changes.size(), 1U);
  EXPECT_EQ(found.comparison.changes[0].kind, ChangeKind::kAmplitude);
  EXPECT_EQ(found.comparison.changes[0].subject, "B4");
  EXPECT_NEAR(found.comparison.changes[0].size, 0.5, 0.02);
  EXPECT_NEAR(found.as_left.beacons[kFree].gain, 0.5, 0.02);
}

/// A beacon was replaced: three stops determine its position and delay, because everything else is known.
TEST(Revisit, ThreeStopsSufficeForOneReplacedBeacon) {
  TwoVisits visits = two_visits([](Scenario& s) { move(s, kFree, {-0.10, 0.05, 0.02}); }, 3);
  for (Arrival& a : visits.second.arrivals)
    if (a.beacon == BeaconId(kFree)) a.tof_s += 120e-6;
  const Revisit found = revisited(visits);
  ASSERT_FALSE(found.comparison.changes.empty());
  for (const Change& c : found.comparison.changes) EXPECT_EQ(c.subject, "B4");
  EXPECT_LT((found.as_left.beacons[kFree].position_m - Eigen::Vector3d(16.10, 12.00, 2.525)).norm(), 0.08);
}

/// Few arrivals, a quarter of them echoes: by the visit alone its place and its delay trade for each other.
TEST(Revisit, ABeaconWithEchoesIsNotAccused) {
  const TwoVisits clean = two_visits([](Scenario&) {});
  for (std::uint64_t seed = 20; seed < 32; ++seed) {
    TwoVisits visits = clean;
    Random draws(seed, 3);
    int heard = 0;
    std::erase_if(visits.second.arrivals,
                  [&](const Arrival& a) { return a.beacon == BeaconId(kFree) && ++heard > 16; });
    for (Arrival& a : visits.second.arrivals)
      if (a.beacon == BeaconId(kFree) && draws.uniform(0.0, 1.0) < 0.25) a.tof_s += draws.uniform(1e-4, 3e-3);
    const Revisit found = revisited(visits);
    EXPECT_TRUE(found.comparison.changes.empty())
        << "seed " << seed << ": " << found.comparison.changes[0].subject;
  }
}

TEST(Revisit, ABeaconOutOfReachIsNotSilent) {
  TwoVisits visits = two_visits([](Scenario&) {});
  // The range of all beacons is a third of the hall, and the vehicle was never that near to this beacon.
  const double reach_m = 6.0;
  std::vector<std::int64_t> near;
  const double speed_mps = 343.0;
  for (const Arrival& a : visits.second.arrivals)
    if (a.beacon == BeaconId(kFree) && a.tof_s * speed_mps < reach_m) near.push_back(a.epoch);
  std::erase_if(visits.second.arrivals, [&](const Arrival& a) {
    return a.tof_s * speed_mps > 2 * reach_m || std::find(near.begin(), near.end(), a.epoch) != near.end() ||
           a.beacon == BeaconId(kFree);
  });
  visits.before.validity_reach_m = reach_m;
  const Revisit found = revisited(visits);
  EXPECT_TRUE(found.silent.empty());
  EXPECT_TRUE(found.comparison.changes.empty());
  EXPECT_EQ(found.not_observed, std::vector<std::string>{"B4"});
  EXPECT_EQ(found.as_left.beacons[kFree].status, BeaconStatus::kCalibrated);
}

TEST(Revisit, ABeaconThatStopsHalfWayIsSilentFromThenOn) {
  TwoVisits visits = two_visits([](Scenario&) {}, 60);
  const std::int64_t half = visits.second.arrivals[visits.second.arrivals.size() / 2].epoch;
  std::erase_if(visits.second.arrivals,
                [half](const Arrival& a) { return a.beacon == BeaconId(kFree) && a.epoch > half; });
  const Revisit found = revisited(visits);
  ASSERT_EQ(found.silent.size(), 1U);
  EXPECT_EQ(found.silent[0].subject, "B4");
  EXPECT_TRUE(found.silent[0].is_partial);
  EXPECT_GT(found.silent[0].expected, 10 * std::max(1.0, found.silent[0].received));
}

/// Two or three stops with an arrival from each pair hardly determine more than the vehicle's places.
TEST(Revisit, FewSingleShotsLeaveTheOldCalibration) {
  const TwoVisits visits = two_visits([](Scenario&) {}, 30);
  for (std::int64_t first = 0; first < 27; first += 3) {
    TwoVisits few = visits;
    std::map<std::tuple<std::int64_t, int, int>, int> shots;
    std::erase_if(few.second.arrivals, [&](const Arrival& a) {
      return a.epoch < first || a.epoch > first + 1 + first % 2 ||
             shots[{a.epoch, a.beacon.value, a.receiver.value}]++ > 0;
    });
    const Revisit found = revisited(few);
    EXPECT_TRUE(found.comparison.changes.empty()) << "from stop " << first;
    for (std::size_t b = 0; b < 8; ++b) {
      const DeploymentBeacon &was = few.before.beacons[b], &is = found.as_left.beacons[b];
      const double sigma_m = std::sqrt(was.covariance_m2.trace()) + 3e-3;
      EXPECT_LT((is.position_m - was.position_m).norm(), 2 * sigma_m) << was.name;
      EXPECT_EQ(is.status, was.status) << was.name;
    }
  }
}

/// All arrivals of a beacon at the only stop where it was received come late: an echo looks like that.
TEST(Revisit, AnEchoAtASingleStopIsNoChange) {
  TwoVisits visits = two_visits([](Scenario&) {}, 3);
  const std::int64_t stop = visits.second.arrivals.front().epoch;
  std::erase_if(visits.second.arrivals,
                [stop](const Arrival& a) { return a.beacon == BeaconId(kFree) && a.epoch != stop; });
  for (Arrival& a : visits.second.arrivals)
    if (a.beacon == BeaconId(kFree)) a.tof_s += 4e-4;
  const Revisit found = revisited(visits);
  EXPECT_TRUE(found.comparison.changes.empty());
  EXPECT_EQ(found.not_judged, std::vector<std::string>{"B4"});
}

TEST(Revisit, AReceiverThatTakesNothingIsSilent) {
  TwoVisits visits = two_visits([](Scenario&) {});
  std::erase_if(visits.second.arrivals, [](const Arrival& a) { return a.receiver.index() == 2; });
  const Revisit found = revisited(visits);
  ASSERT_EQ(found.silent.size(), 1U);
  EXPECT_EQ(found.silent[0].subject, found.receivers[2].name);
}

TEST(Revisit, WhatWasNotHeardIsCarriedOver) {
  TwoVisits visits = two_visits([](Scenario&) {});
  std::erase_if(visits.second.arrivals, [](const Arrival& a) { return a.beacon == BeaconId(kFree); });
  const Revisit found = revisited(visits);
  EXPECT_TRUE(found.comparison.changes.empty());
  EXPECT_EQ(found.beacons[kFree].used, 0U);
  ASSERT_EQ(found.silent.size(), 1U);
  EXPECT_EQ(found.silent[0].subject, "B4");
  EXPECT_EQ(found.silent[0].received, 0.0);
  EXPECT_GT(found.silent[0].expected, 20.0);
  EXPECT_EQ(found.as_left.beacons[kFree].status, BeaconStatus::kCalibrated);
  EXPECT_LT((found.as_left.beacons[kFree].position_m - visits.before.beacons[kFree].position_m).norm(), 5e-3);
  EXPECT_GT(found.as_left.beacons[kFree].covariance_m2.trace(),
            0.9 * visits.before.beacons[kFree].covariance_m2.trace());
}

/// diff of the two files agrees with recalibrate.
TEST(Revisit, TheDifferenceOfBothDeploymentsSaysTheSame) {
  const TwoVisits visits = two_visits([](Scenario& s) { move(s, kFree, {0.04, -0.01, 0.0}); });
  const Revisit found = revisited(visits);
  const Deployment now = finished(found, visits.before, {"2026-07-01T00:00:00Z", "", "", {}});
  ASSERT_TRUE(now.previous.has_value());
  EXPECT_EQ(now.previous->sha256, "first");
  EXPECT_EQ(parameter_names(now.previous->released.parameters, names_of(now)),
            (std::vector<std::string>{"beacon/B4/x_m", "beacon/B4/y_m", "beacon/B4/z_m"}));
  EXPECT_FALSE(now.previous->released.datum);
  const Comparison difference = compare(visits.before, now, {});
  ASSERT_EQ(difference.changes.size(), 1U);
  EXPECT_EQ(difference.changes[0].subject, "B4");
  EXPECT_NEAR(difference.changes[0].size, found.comparison.changes[0].size,
              found.comparison.changes[0].sigma);
}

/// Each pair has an error of this number of sigmas for about ten stops.
void keep_errors(MeasurementLog& run, double sigma_s) {
  Random draws(31, 2);
  const double keep = std::exp(-0.1), fresh = std::sqrt(1 - keep * keep);
  std::map<std::pair<int, int>, std::pair<std::int64_t, double>> kept;  // stop and value
  for (Arrival& a : run.arrivals) {
    auto [at, is_new] = kept.try_emplace({a.beacon.value, a.receiver.value}, a.epoch, draws.normal());
    for (; at->second.first < a.epoch; ++at->second.first)
      at->second.second = keep * at->second.second + fresh * draws.normal();
    a.tof_s += sigma_s * at->second.second;
  }
}

/// Information of a visit: by the errors that it shows if they are larger, otherwise by the given ones.
TEST(Revisit, TheLargerErrorModelOfBothVisitsCounts) {
  TwoVisits visits = two_visits([](Scenario&) {}, 60);
  const double noise_s = visits.before.noise.tof_sigma_s;
  const auto left = [&](double stated_s) {
    visits.before.correlated_noise = {stated_s, 50.0, 0.0};
    return revisited(visits).as_left.beacons[kFree].covariance_m2.trace();
  };
  const double white = left(0.0);
  keep_errors(visits.second, noise_s);
  const double shown = left(0.0), little = left(0.05 * noise_s), much = left(4 * noise_s);
  EXPECT_GT(shown, 1.2 * white);  // by a third, and much by 3 % more: the visit then tells next to nothing
  EXPECT_NEAR(little / shown, 1.0, 0.02);
  EXPECT_GT(much, 1.015 * shown);
}

/// Second visits add information: parameters that neither moved nor drifted are known better than before.
TEST(Revisit, SigmasOfTheNewDeploymentHold) {
  const int visits = 12;
  double nees = 0.0;
  Eigen::Index count = 0;
  Scenario scenario = first_scenario();
  for (int seed = 0; seed < visits; ++seed) {
    const World first = must(simulate(scenario, 100 + static_cast<std::uint64_t>(seed)));
    Problem problem = must(make_problem(first.site, {first.run}));
    Deployment before = make_deployment(problem, solve(problem), {"2026-01-01T00:00:00Z", "", "", {}});
    Scenario again = scenario;
    move(again, kFree, {0.05, 0.0, 0.0});
    again.path.epochs = 20;
    const Revisit found =
        must(revisit(before, {must(simulate(again, 200 + static_cast<std::uint64_t>(seed))).run}, {}));
    for (std::size_t b = 0; b < 8; ++b) {
      const DeploymentBeacon& left = found.as_left.beacons[b];
      if (left.status != BeaconStatus::kCalibrated) continue;
      Eigen::Vector3d truth;
      for (std::size_t i = 0; i < 3; ++i)
        truth[static_cast<Eigen::Index>(i)] = *again.site.beacons[b].position_m[i];
      const Eigen::Vector3d off = left.position_m - truth;
      nees += off.dot(left.covariance_m2.ldlt().solve(off));
      count += 3;
    }
  }
  EXPECT_GE(count, visits * 15);
  // The drift that is allowed for is not there, so that sigmas are too large rather than too small.
  EXPECT_GT(nees / static_cast<double>(count), 0.3);
  EXPECT_LT(nees / static_cast<double>(count), 1.3);
}

}  // namespace revisit_test
}  // namespace octant::calib
