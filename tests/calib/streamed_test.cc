// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/streamed.h"

#include <numeric>

#include <gtest/gtest.h>

#include "calib/stream/long_log.h"
#include "calib/verdict/validity.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/memory_source.h"
#include "tests/calib/stream/changed_log.h"
#include "tests/calib/stream/same_drive.h"
#include "tests/calib/stream/share_of_ranks.h"

namespace octant::test {
namespace streamed_test {

constexpr std::size_t kTiny = 8U << 20U;  // some thousands of arrivals at a time

Scenario long_hall(int epochs, double echoes = 0.01) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  s.heldout_path.epochs = 1;
  s.echo_fraction = echoes;
  return s;
}

calib::StreamedCalibration streamed(const Site& site, MemorySource& source,
                                    const calib::SolveOptions& options = {}, std::size_t memory = kTiny) {
  return must(calib::solve_streamed(site, source, options, memory));
}
calib::StreamedCalibration streamed(const Site& site, const std::vector<MeasurementLog>& runs,
                                    const calib::SolveOptions& options = {}, std::size_t memory = kTiny) {
  MemorySource source(runs, 300);
  return streamed(site, source, options, memory);
}

double largest_shift_m(const calib::Solution& a, const calib::Solution& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.state.beacon_p_map_m.size(); ++i)
    largest = std::max(largest, (a.state.beacon_p_map_m[i] - b.state.beacon_p_map_m[i]).norm());
  return largest;
}

/// Agreement of the streamed log with the log in memory.
struct Agreement {
  /// Tolerance of the root mean square without weights: if the noise of arrivals differs, the states do not
  /// minimise it, and the remainder of their last step affects it to first order.
  double rms_share = 1e-8;
  double shift_m = 1e-7;  ///< of beacons
};

/// Compares all results for a log, streamed or not. Positions: both end when the cost changes by a relative
/// 1e-12, which is a thousandth of a sigma.
void expect_same(const calib::Problem& problem, const calib::Solution& whole,
                 const calib::StreamedCalibration& s, const Agreement& to = {}) {
  const calib::Solution& part = s.solution;
  ASSERT_EQ(part.status, whole.status) << part.message;
  EXPECT_LT(largest_shift_m(whole, part), to.shift_m);
  ASSERT_EQ(part.covariance.parameters, whole.covariance.parameters);
  const double scale = whole.covariance.matrix.cwiseAbs().maxCoeff();
  EXPECT_LT((part.covariance.matrix - whole.covariance.matrix).cwiseAbs().maxCoeff(), 1e-6 * scale);
  EXPECT_EQ(part.statistics.arrivals, whole.statistics.arrivals);
  EXPECT_EQ(part.statistics.rejected, whole.statistics.rejected);
  EXPECT_EQ(part.statistics.unknowns, whole.statistics.unknowns);
  EXPECT_EQ(part.statistics.redundancy, whole.statistics.redundancy);
  EXPECT_NEAR(part.statistics.variance_factor, whole.statistics.variance_factor,
              1e-8 * whole.statistics.variance_factor);
  EXPECT_NEAR(part.statistics.rms_s, whole.statistics.rms_s, to.rms_share * whole.statistics.rms_s);
  EXPECT_NEAR(part.tof_sigma_s, whole.tof_sigma_s, 1e-8 * whole.tof_sigma_s);
  EXPECT_EQ(part.warnings, whole.warnings);
  EXPECT_EQ(part.beacon_status, whole.beacon_status);
  EXPECT_DOUBLE_EQ(s.problem.typical_range_m, problem.typical_range_m);
  ASSERT_TRUE(part.totals);
  std::vector<std::size_t> left_out(calib::kRejections, 0), counted(calib::kRejections, 0);
  for (const calib::LeftOut& l : whole.left_out) ++left_out[static_cast<std::size_t>(l.reason)];
  for (std::size_t b = 0; b < part.totals->of_beacon.size(); ++b)
    for (std::size_t r = 1; r < calib::kRejections; ++r) counted[r] += part.totals->of_beacon[b][r];
  EXPECT_EQ(counted, left_out);
  // The examined epochs are those that would be examined of the whole.
  ASSERT_TRUE(part.reliability.ok);
  EXPECT_EQ(part.reliability.stride, whole.reliability.stride);
  ASSERT_EQ(part.reliability.arrivals.size(), whole.reliability.arrivals.size());
  EXPECT_NEAR(part.reliability.redundancy_sum, whole.reliability.redundancy_sum,
              1e-6 * whole.reliability.redundancy_sum);
  for (std::size_t i = 0; i < part.reliability.arrivals.size(); i += 97)
    EXPECT_NEAR(part.reliability.arrivals[i].w, whole.reliability.arrivals[i].w, 1e-3);
  for (std::size_t b = 0; b < part.reliability.beacons.size(); ++b) {
    EXPECT_EQ(part.reliability.beacons[b].used, whole.reliability.beacons[b].used);
    EXPECT_EQ(part.reliability.beacons[b].late, whole.reliability.beacons[b].late);
    EXPECT_EQ(part.reliability.beacons[b].other, whole.reliability.beacons[b].other);
  }
  const Deployment a = calib::make_deployment(problem, whole, {}),
                   b = calib::make_deployment(s.problem, part, {});
  ASSERT_EQ(a.validity_area_m.size(), b.validity_area_m.size());
  for (std::size_t i = 0; i < a.validity_area_m.size(); ++i)
    EXPECT_LT((a.validity_area_m[i] - b.validity_area_m[i]).norm(), 1e-6);
  EXPECT_EQ(a.validity_temperature_degC, b.validity_temperature_degC);
}

void expect_same(const World& world, const Site& site, const Agreement& to = {}) {
  calib::Problem problem = must(calib::make_problem(site, {world.run}));
  ASSERT_TRUE(calib::is_long(problem));
  const calib::Solution whole = calib::solve(problem, {});
  expect_same(problem, whole, streamed(site, {world.run}), to);
}

TEST(Streamed, SaysWhatTheWholeSays) {
  const World world = must(simulate(long_hall(4100, 0.03), 2));
  expect_same(world, world.site);
}

// With more epochs than are examined singly, and some for which the search finds no pose.
TEST(Streamed, SaysWhatTheWholeSaysOfSomeEpochs) {
  World world = must(simulate(long_hall(6200, 0.01), 3));
  std::erase_if(world.run.arrivals,
                [](const Arrival& a) { return a.epoch % 500 == 7 && a.beacon.value % 3 != 0; });
  expect_same(world, world.site);
}

// The estimated noise: with a large error, and with one that only the chi-square test detects.
TEST(Streamed, FindsTheNoiseOfTheWhole) {
  const World world = must(simulate(long_hall(4100, 0.01), 5));
  for (const double factor : {0.3, 1.1}) {
    Site site = world.site;
    site.noise.tof_sigma_s *= factor;
    expect_same(world, site);
  }
}

// Each arrival has a noise of its own.
TEST(Streamed, ReceiversMayBeDirectional) {
  Scenario s = long_hall(4100);
  add_attenuation(s);
  s.log_amplitude = true;
  s.site.attenuation->half_power_angle_rad = {0.6, 0.1};
  const World world = must(simulate(s, 14));
  expect_same(world, world.site, {.rms_share = 1e-6});
}

TEST(Streamed, EpochsMayHaveClockOffsets) {
  Scenario s = long_hall(4100);
  s.site.timing.clock = Clock::kCycleOffset;
  s.site.timing.delay_per = {};
  s.true_delay_s.reset();
  const World world = must(simulate(s, 15));
  // A thousandth of the beacons' sigma: offsets are solved together with the poses, to the same share of the
  // cost.
  expect_same(world, world.site, {.shift_m = 4e-7});
}

TEST(Streamed, RangesMayBeTwoWay) {
  Scenario s = long_hall(4100);
  s.site.timing.ranging = Ranging::kTwoWay;
  s.site.timing.turnaround_s = 1e-3;
  const World world = must(simulate(s, 17));
  expect_same(world, world.site);
}

TEST(Streamed, PosesOfStopsMayBeMeasured) {
  Scenario s = long_hall(4100);
  s.log_poses = true;
  const World world = must(simulate(s, 16));
  expect_same(world, world.site);
}

TEST(Streamed, StopsMayHaveBearings) {
  Scenario s = long_hall(4100);
  s.site.noise.bearing_sigma_rad = 0.02;
  s.bearings = Scenario::Bearings{.unlabelled_fraction = 0.1};
  World world = must(simulate(s, 19));
  ASSERT_GT(world.run.bearings.size(), 4000U);
  for (std::size_t i = 0; i < world.run.bearings.size(); i += 50) world.run.bearings[i].bearing_rad += 0.5;
  const calib::Problem problem = must(calib::make_problem(world.site, {world.run}));
  ASSERT_TRUE(calib::is_long(problem));
  const calib::Solution whole = calib::solve(problem, {});
  const calib::StreamedCalibration part = streamed(world.site, {world.run});
  expect_same(problem, whole, part);
  expect_same_bearings(whole, part.solution);
}

// A stop with bearings only is not part of a log that is indexed by its arrivals; there is a warning.
TEST(Streamed, BearingsOfSilentStopsAreLeftOutAndSaidToBe) {
  Scenario s = long_hall(4100);
  s.site.noise.bearing_sigma_rad = 0.02;
  s.bearings = Scenario::Bearings{};
  World world = must(simulate(s, 19));
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return a.epoch == 77; });
  const auto of_it = std::count_if(world.run.bearings.begin(), world.run.bearings.end(),
                                   [](const Bearing& b) { return b.epoch == 77; });
  ASSERT_GT(of_it, 0);
  const calib::Solution solution = streamed(world.site, {world.run}).solution;
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  EXPECT_EQ(std::count_if(solution.left_out_bearings.begin(), solution.left_out_bearings.end(),
                          [](const auto& b) { return b.reason == Rejection::kNoPose; }),
            of_it);
  EXPECT_TRUE(std::any_of(solution.warnings.begin(), solution.warnings.end(), [](const std::string& words) {
    return words.find("stops at which nothing was heard") != std::string::npos;
  }));
}

TEST(Streamed, StopsMayBeInSpace) {
  Scenario s = long_hall(4100);
  s.site.motion = Motion::kSpatial;
  s.log_poses = true;
  const World world = must(simulate(s, 18));
  expect_same(world, world.site);
}

TEST(Streamed, RunsKeepTheirSpeeds) {
  const World world = must(simulate(long_hall(4100), 6));
  Site site = world.site;
  site.speed_offset_per_run = true;
  MeasurementLog first = world.run, second = world.run;
  second.path = "second";
  std::erase_if(first.arrivals, [](const Arrival& a) { return a.epoch >= 2200; });
  std::erase_if(second.arrivals, [](const Arrival& a) { return a.epoch < 2200; });
  for (Arrival& a : second.arrivals)
    a.tof_s += 5e-4 * (a.tof_s - world.truth.beacons[a.beacon.index()].delay_s);
  const calib::Problem problem = must(calib::make_problem(site, {first, second}));
  ASSERT_TRUE(calib::is_long(problem));
  const calib::Solution whole = calib::solve(problem, {});
  expect_same(problem, whole, streamed(site, {first, second}));
}

TEST(Streamed, DependsNeitherOnThreadsNorOnBlocks) {
  const World world = must(simulate(long_hall(4200), 8));
  calib::SolveOptions options;
  const calib::Solution one = streamed(world.site, {world.run}, options).solution;
  options.threads = 3;
  const calib::Solution three = streamed(world.site, {world.run}, options).solution;
  EXPECT_EQ(largest_shift_m(one, three), 0.0);
  EXPECT_EQ(one.statistics.variance_factor, three.statistics.variance_factor);
  MemorySource other(std::vector<MeasurementLog>{world.run}, 4097);
  const calib::Solution blocks = streamed(world.site, other, options, 10 * kTiny).solution;
  EXPECT_LT(largest_shift_m(one, blocks), 1e-9);
  EXPECT_EQ(one.statistics.rejected, blocks.statistics.rejected);
}

TEST(Streamed, RanksReadTheirShareAndAgree) {
  const World world = must(simulate(long_hall(4200), 9));
  expect_ranks_to_share_and_agree(world, kTiny, {2, 4}, largest_shift_m, 1e-9);
}

TEST(Streamed, StopsWhereItIsAskedTo) {
  const World world = must(simulate(long_hall(4200), 10));
  for (const char* stage : {"first reading of the log", "states of the whole log",
                            "adjustment of the arrivals that agree", "covariance and verdict"}) {
    calib::SolveOptions options;
    int calls = 0;
    options.on_progress = [&](const calib::Progress& p) { return p.stage != stage || ++calls < 3; };
    EXPECT_EQ(streamed(world.site, {world.run}, options).solution.status,
              std::string(stage) == "first reading of the log" ? calib::SolveStatus::kConverged
                                                               : calib::SolveStatus::kInterrupted)
        << stage;
    calls = 2;
    EXPECT_EQ(streamed(world.site, {world.run}, options).solution.status, calib::SolveStatus::kInterrupted)
        << stage;
  }
}

TEST(Streamed, AFileThatChangesIsAnError) {
  expect_a_changed_log_to_be_an_error(must(simulate(long_hall(4200), 11)));
}

TEST(Streamed, RefusesWhatIsRefused) {
  const World world = must(simulate(long_hall(4200), 12));
  Site site = world.site;
  for (SiteBeacon& b : site.beacons) b.position_m = {}, b.sigma_m = {};
  site.speed_sigma_mps = 200.0;
  for (SiteReceiver& r : site.receivers) r.sigma_m.setConstant(1.0);
  const calib::Solution s = streamed(site, {world.run}).solution;
  EXPECT_EQ(s.status, calib::SolveStatus::kUndetermined);
  EXPECT_NE(s.message.find("speed of sound"), std::string::npos) << s.message;
}

}  // namespace streamed_test
}  // namespace octant::test
