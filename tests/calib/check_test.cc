// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Findings in recordings before a calibration: their health, and the verdict predicted from a part of them.
#include "calib/check.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/problem/clock_check.h"
#include "calib/problem/unit_check.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace check_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Texts of one kind.
std::vector<std::string> texts(const std::vector<calib::Finding>& findings, const std::string& kind) {
  std::vector<std::string> found;
  for (const auto& f : findings)
    if (f.kind == kind) found.push_back(f.text);
  return found;
}

std::vector<calib::Finding> suspicions_of(const World& world) {
  std::vector<calib::RunHealth> health = {calib::log_health(world.site, world.run)};
  return calib::suspicions(calib::forecast(problem_of(world)), health);
}

World hall(int epochs = 120, std::uint64_t seed = 1) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  return must(simulate(s, seed));
}

TEST(LogHealth, CountsOfAGoodHall) {
  const World world = hall(60);
  const auto h = calib::log_health(world.site, world.run);
  EXPECT_EQ(h.arrivals, world.run.arrivals.size());
  EXPECT_EQ(h.instants, 60U);
  std::size_t by_beacon = 0, by_receiver = 0;
  for (const auto& l : h.beacons) by_beacon += l.arrivals;
  for (const auto& l : h.receivers) by_receiver += l.arrivals;
  EXPECT_EQ(by_beacon, h.arrivals);
  EXPECT_EQ(by_receiver, h.arrivals);
  EXPECT_NEAR(h.beacons[0].rate_hz * h.duration_s, static_cast<double>(h.beacons[0].arrivals), 1e-9);
  EXPECT_GT(h.median_range_m, 4.0);
  EXPECT_LT(h.median_range_m, 12.0);
  EXPECT_THAT(h.findings, IsEmpty());
  EXPECT_THAT(calib::silent_links(world.site, {h}), IsEmpty());
}

TEST(LogHealth, NamesASilentBeaconAndADeafReceiver) {
  World world = hall(40);
  std::erase_if(world.run.arrivals,
                [](const Arrival& a) { return a.beacon == BeaconId(5) || a.receiver == ReceiverId(3); });
  const auto found = calib::silent_links(world.site, {calib::log_health(world.site, world.run)});
  ASSERT_EQ(texts(found, "silent_beacon").size(), 1U);
  EXPECT_THAT(texts(found, "silent_beacon")[0], HasSubstr("B5"));
  ASSERT_EQ(texts(found, "deaf_receiver").size(), 1U);
  EXPECT_THAT(texts(found, "deaf_receiver")[0], HasSubstr("robot/r3"));
}

TEST(LogHealth, FindsPausesDuplicatesAndRowsBackInTime) {
  World world = hall(40);
  auto& arrivals = world.run.arrivals;
  for (Arrival& a : arrivals)
    if (a.epoch >= 20) a.time_s += 600.0;
  arrivals.insert(arrivals.begin() + 4, arrivals[3]);
  auto h = calib::log_health(world.site, world.run);
  ASSERT_EQ(h.gaps.size(), 1U);
  EXPECT_NEAR(h.gaps[0].to_s - h.gaps[0].from_s, 605.0, 5.0);
  EXPECT_EQ(h.duplicates, 1U);
  EXPECT_EQ(texts(h.findings, "duplicate").size(), 1U);
  EXPECT_EQ(h.backwards, 0U);
  std::swap(arrivals.front().time_s, arrivals.back().time_s);
  h = calib::log_health(world.site, world.run);
  EXPECT_GT(h.backwards, 0U);
}

TEST(LogHealth, ConstantAndQuantisedValues) {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  s.quantum_s = 1e-4;
  World world = must(simulate(s, 3));
  auto h = calib::log_health(world.site, world.run);
  EXPECT_NEAR(h.resolution_s, 1e-4, 1e-9);
  EXPECT_EQ(texts(h.findings, "quantised").size(), 1U);
  for (Arrival& a : world.run.arrivals)
    if (a.beacon == BeaconId(2)) a.tof_s = 0.01;
  h = calib::log_health(world.site, world.run);
  EXPECT_THAT(h.constant, ::testing::ElementsAre("B2"));
  EXPECT_EQ(calib::log_health(hall(60).site, hall(60).run).resolution_s, 0.0)
      << "continuous values have none";
}

TEST(LogHealth, MissingTemperatureMattersWhereTheSpeedIsHeld) {
  World world = hall(20);
  EXPECT_THAT(texts(calib::log_health(world.site, world.run).findings, "temperature"), IsEmpty())
      << "two metres a second are free";
  world.site.speed_sigma_mps = 0.0;
  EXPECT_EQ(texts(calib::log_health(world.site, world.run).findings, "temperature").size(), 1U);
  world.run.temperature_degC = 21.0;
  EXPECT_THAT(texts(calib::log_health(world.site, world.run).findings, "temperature"), IsEmpty());
}

TEST(UnitCheck, NamesTheUnit) {
  const World world = hall(30);
  const std::pair<double, const char*> units[] = {
      {1e3, "like milliseconds"}, {1e6, "like microseconds"}, {1e9, "like nanoseconds"}, {345.0, "metres"}};
  for (const auto& [factor, name] : units) {
    World wrong = world;
    for (Arrival& a : wrong.run.arrivals) a.tof_s *= factor;
    const auto found = texts(calib::check_units(wrong.site, wrong.run), "unit");
    ASSERT_EQ(found.size(), 1U) << name;
    EXPECT_THAT(found[0], HasSubstr(name));
  }
  EXPECT_THAT(calib::check_units(world.site, world.run), IsEmpty());
}

TEST(UnitCheck, ThereAndBackForOneWayAndTheReverse) {
  World world = hall(60);
  for (Arrival& a : world.run.arrivals) a.tof_s *= 2.0;
  auto found = texts(calib::check_units(world.site, world.run), "two_way");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0], HasSubstr("there and back"));

  world = hall(60);
  world.site.timing.ranging = Ranging::kTwoWay;  // but the log is one way
  found = texts(calib::check_units(world.site, world.run), "two_way");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0], HasSubstr("half"));
}

TEST(UnitCheck, ManyEchoesAreNoFactorTwo) {
  Scenario s = hall_scenario();
  s.echo_fraction = 0.3;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const World world = must(simulate(s, seed));
    EXPECT_THAT(calib::check_units(world.site, world.run), IsEmpty()) << seed;
  }
}

TEST(Thin, KeepsEveryBeaconAndFewEpochsOfMany) {
  World world = hall(20);
  // 20,000 epochs with B5 in every five hundredth only.
  MeasurementLog big = world.run;
  big.arrivals.clear();
  for (int copy = 0; copy < 1000; ++copy)
    for (Arrival a : world.run.arrivals) {
      a.epoch += 20 * copy;
      a.time_s += 100.0 * copy;
      if (a.beacon == BeaconId(5) && a.epoch % 500 != 0) continue;
      big.arrivals.push_back(a);
    }
  const MeasurementLog few = calib::subsample(big, world.site);
  std::set<std::int64_t> epochs;
  std::vector<std::size_t> heard(world.site.beacons.size(), 0), all = heard;
  for (const Arrival& a : few.arrivals) {
    epochs.insert(a.epoch);
    ++heard[a.beacon.index()];
  }
  for (const Arrival& a : big.arrivals) ++all[a.beacon.index()];
  EXPECT_GE(epochs.size(), 300U);
  EXPECT_LE(epochs.size(), 400U);
  EXPECT_GT(*epochs.rbegin(), 19'000) << "evenly to the end";
  for (std::size_t b = 0; b < heard.size(); ++b) EXPECT_GE(heard[b], std::min<std::size_t>(all[b], 40)) << b;
  EXPECT_TRUE(std::is_sorted(few.arrivals.begin(), few.arrivals.end(),
                             [](const Arrival& a, const Arrival& b) { return a.time_s < b.time_s; }));
  // Whole epochs with the same number of arrivals as the original.
  std::size_t in_them = 0;
  for (const Arrival& a : big.arrivals) in_them += epochs.contains(a.epoch);
  EXPECT_EQ(few.arrivals.size(), in_them);
  EXPECT_EQ(calib::subsample(world.run, world.site).arrivals.size(), world.run.arrivals.size())
      << "small ones stay";
}

TEST(Thin, ALongStandKeepsSomeOfEachPair) {
  World world = hall(3);
  MeasurementLog stand = world.run;
  stand.arrivals.clear();
  for (const Arrival& a : world.run.arrivals)
    for (int i = 0; i < 500; ++i) stand.arrivals.push_back(a);
  EXPECT_EQ(calib::subsample(stand, world.site).arrivals.size(), 16 * world.run.arrivals.size());
}

// A segment is three seconds long; a request for few gets few, and never more than a site needs.
TEST(Thin, ADriveKeepsAsFewStretchesAsAreAskedFor) {
  const World world = must(simulate(drive_scenario(300.0), 1));
  const auto kept = [&](std::size_t fewest) {
    const MeasurementLog few = calib::subsample(
        world.run, world.site, {.per_beacon = 0, .drive_arrivals = 1, .fewest_stretches = fewest});
    std::set<long> stretches;
    for (const Arrival& a : few.arrivals)
      stretches.insert(std::lround(std::floor((a.time_s - world.run.arrivals.front().time_s) / 3.0)));
    return stretches.size();
  };
  EXPECT_EQ(kept(8), 8U);
  EXPECT_EQ(kept(1000), 30U);
}

TEST(Thin, OdometryOfADriveAddsUpToTheSameWay) {
  const World world = must(simulate(drive_scenario(900.0), 1));
  const MeasurementLog few = calib::subsample(world.run, world.site, {.drive_arrivals = 2000});
  EXPECT_LT(few.arrivals.size(), world.run.arrivals.size() / 2);
  EXPECT_LT(few.odometry.size(), world.run.odometry.size() / 2);
  const auto way = [](const MeasurementLog& run) {
    Pose T;
    for (std::size_t i = 1; i < run.odometry.size(); ++i)
      T = T * Pose::planar(run.odometry[i].dx_m, run.odometry[i].dy_m, run.odometry[i].dheading_rad);
    return T;
  };
  EXPECT_EQ(few.odometry.back().time_s, world.run.odometry.back().time_s);
  EXPECT_NEAR((way(few).translation_m - way(world.run).translation_m).norm(), 0.0, 1e-9);
  // Each arrival that is kept lies between the same two rows as before.
  const auto rows_at = [](const MeasurementLog& run, double t) {
    const auto after =
        std::upper_bound(run.odometry.begin(), run.odometry.end(), t,
                         [](double time_s, const OdometryStep& s) { return time_s < s.time_s; });
    return after == run.odometry.begin() || after == run.odometry.end()
               ? std::pair(0.0, 0.0)
               : std::pair((after - 1)->time_s, after->time_s);
  };
  for (const Arrival& a : few.arrivals) EXPECT_EQ(rows_at(few, a.time_s), rows_at(world.run, a.time_s));
}

/// Predicted sigmas against those of the whole calibration: the subsampled geometry is another sample of the
/// same paths.
void expect_like_calibrate(const World& world, const calib::SubsampleOptions& options) {
  const calib::Problem problem = problem_of(world);
  const auto forecast = calib::forecast(problem, {}, options);
  const auto whole = calib::solve(problem);
  ASSERT_TRUE(forecast.is_subsampled());
  EXPECT_LT(forecast.arrivals_used, forecast.arrivals / 2);
  EXPECT_EQ(forecast.solution.status, calib::SolveStatus::kConverged) << forecast.solution.message;
  EXPECT_EQ(whole.status, calib::SolveStatus::kConverged);
  ASSERT_EQ(forecast.solution.covariance.parameters, whole.covariance.parameters);
  for (std::size_t i = 0; i < whole.covariance.parameters.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double ratio = std::sqrt(forecast.solution.covariance.matrix(k, k) / whole.covariance.matrix(k, k));
    EXPECT_GT(ratio, 1 / 1.5) << parameter_name(whole.covariance.parameters[i], names_of(problem.site));
    EXPECT_LT(ratio, 1.5) << parameter_name(whole.covariance.parameters[i], names_of(problem.site));
  }
  for (const auto& b : forecast.beacons) {
    ASSERT_TRUE(b.sigma_m) << b.name;
    EXPECT_EQ(b.status == BeaconStatus::kControlPoint, b.sigma_m->norm() == 0.0);
  }
  ASSERT_TRUE(forecast.speed_sigma_mps);
  EXPECT_GT(*forecast.speed_sigma_mps, 0.0);
}

TEST(Forecast, OfStopsIsWithinHalfOfTheWholeCalibration) {
  expect_like_calibrate(hall(600), {.instants = 150});
}
TEST(Forecast, OfADriveIsWithinHalfOfTheWholeCalibration) {
  expect_like_calibrate(must(simulate(drive_scenario(300.0), 2)), {.drive_arrivals = 1500});
}

TEST(Forecast, OfASmallRunIsTheCalibrationItself) {
  const World world = hall(60);
  const auto forecast = calib::forecast(problem_of(world));
  const auto whole = solution_of(world);
  EXPECT_FALSE(forecast.is_subsampled());
  EXPECT_EQ(forecast.solution.covariance.matrix, whole.covariance.matrix);
  std::vector<calib::RunHealth> health = {calib::log_health(world.site, world.run)};
  EXPECT_THAT(calib::suspicions(forecast, health), IsEmpty());
}

/// Thinned or not, the verdict is calibrate's: status and undetermined parameters.
void expect_same_refusal(const World& world, const std::string& parameter) {
  const calib::Problem problem = problem_of(world);
  const calib::Solution whole = must(calib::calibrate(world.site, {world.run})).solution;
  ASSERT_EQ(whole.status, calib::SolveStatus::kUndetermined) << whole.message;
  EXPECT_THAT(whole.undetermined, ::testing::Contains(HasSubstr(parameter)));
  for (const std::size_t instants : {300U, 40U}) {
    const auto forecast = calib::forecast(problem, {}, {.instants = instants});
    EXPECT_EQ(forecast.solution.status, calib::SolveStatus::kUndetermined)
        << instants << forecast.solution.message;
    EXPECT_EQ(forecast.solution.undetermined, whole.undetermined) << instants;
    ASSERT_EQ(forecast.solution.weak.size(), whole.weak.size());
    for (std::size_t i = 0; i < whole.weak.size(); ++i)
      EXPECT_EQ(forecast.solution.weak[i].remedy, whole.weak[i].remedy);
  }
}

TEST(Forecast, RefusesWhereNoLengthIsKnown) {
  Scenario s = hall_scenario();
  s.site.vehicles.clear();
  s.site.receivers.clear();
  add_receivers(s.site, {{0.0, 0.0, 0.3}});
  s.site.speed_sigma_mps = 100.0;
  s.true_temperature_offset_degC.reset();
  s.true_speed_offset_mps = 1.0;
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {3.0, 3.0, 3.0};
  expect_same_refusal(must(simulate(s, 1)), "medium/speed_mps");
}

TEST(Forecast, RefusesThreeEpochs) {
  Scenario s = hall_scenario();
  s.path.epochs = 3;
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {0.5, 0.5, 0.5};
  expect_same_refusal(must(simulate(s, 1)), "beacon/");
}

TEST(Forecast, RefusesASingleBeacon) {
  Scenario s = hall_scenario();
  s.site.beacons = {beacon("B0", {3.9, 0.05, 2.52}, std::nullopt)};
  s.unknown_beacons = true;
  expect_same_refusal(must(simulate(s, 1)), "beacon/B0");
}

TEST(Forecast, SilentBeaconIsUndeterminedAsCalibrateSays) {
  World world = hall(120);
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return a.beacon == BeaconId(5); });
  const auto whole = solution_of(world);
  const auto forecast = calib::forecast(problem_of(world), {}, {.instants = 50});
  EXPECT_EQ(forecast.solution.status, whole.status);
  EXPECT_EQ(forecast.solution.undetermined, whole.undetermined);
  EXPECT_EQ(forecast.beacons[5].status, BeaconStatus::kUndetermined);
  EXPECT_FALSE(forecast.beacons[5].sigma_m);
}

TEST(Suspicions, ExchangedReceiversAreNamed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    World world = hall(120, seed);
    for (Arrival& a : world.run.arrivals) {
      if (a.receiver == ReceiverId(0))
        a.receiver = ReceiverId(4);
      else if (a.receiver == ReceiverId(4))
        a.receiver = ReceiverId(0);
    }
    const auto found = texts(suspicions_of(world), "receiver_label");
    ASSERT_EQ(found.size(), 1U) << seed;
    EXPECT_THAT(found[0], HasSubstr("receivers r0 and r4 of robot are exchanged"));
  }
}

TEST(Suspicions, ClockJumpBetweenStopsIsFound) {
  for (const double jump_s : {1e-3, -3e-3}) {
    World world = hall(120);
    const double at_s = world.run.arrivals[world.run.arrivals.size() * 2 / 3].time_s;
    double first_after_s = INFINITY;
    std::int64_t epoch = kNoEpoch;
    for (Arrival& a : world.run.arrivals) {
      if (a.time_s >= at_s && epoch == kNoEpoch) epoch = a.epoch + 1;
      if (epoch == kNoEpoch || a.epoch < epoch) continue;
      first_after_s = std::min(first_after_s, a.time_s);
      a.tof_s += jump_s;
    }
    std::vector<calib::RunHealth> health = {calib::log_health(world.site, world.run)};
    const auto found = calib::suspicions(calib::forecast(problem_of(world)), health);
    ASSERT_EQ(health[0].clock_steps.size(), 1U) << jump_s;
    EXPECT_NEAR(health[0].clock_steps[0].time_s, first_after_s, 5.1) << "to a stop";
    // Delays and positions of the beacons absorb a part of it, as in a third of the stops.
    EXPECT_NEAR(health[0].clock_steps[0].step_s, jump_s, 0.25 * std::abs(jump_s));
    EXPECT_EQ(texts(found, "clock_step").size(), 1U);
  }
}

TEST(ClockCheck, JumpInADriveIsSeenInTheRangesAlone) {
  World world = must(simulate(drive_scenario(60.0), 1));
  EXPECT_THAT(calib::steps_in_ranges(world.site, world.run), IsEmpty());
  const double at_s = world.run.arrivals[world.run.arrivals.size() / 2].time_s;
  for (Arrival& a : world.run.arrivals)
    if (a.time_s > at_s) a.tof_s += 10e-3;
  const auto steps = calib::steps_in_ranges(world.site, world.run);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_NEAR(steps[0].time_s, at_s, 1.0);
  EXPECT_NEAR(steps[0].step_s, 10e-3, 2e-3);
}

TEST(ClockCheck, EchoesAreNoJumps) {
  for (const bool drive : {false, true}) {
    Scenario s = drive ? drive_scenario(60.0) : hall_scenario();
    s.echo_fraction = 0.3;
    s.early_fraction = 0.02;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const World world = must(simulate(s, seed));
      EXPECT_THAT(calib::steps_in_ranges(world.site, world.run), IsEmpty()) << drive << seed;
      const auto found = suspicions_of(world);
      EXPECT_TRUE(found.empty()) << drive << seed << (found.empty() ? "" : found.front().text);
    }
  }
}

}  // namespace check_test
}  // namespace octant::test
