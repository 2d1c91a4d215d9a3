// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Stops and drives of one calibration.
#include "calib/stream/streamed_log.h"

#include <gtest/gtest.h>

#include "calib/stream/long_log.h"
#include "tests/calib/stream/same_drive.h"
#include "tests/calib/thread_team.h"

namespace octant::test {
namespace {

/// The run drives, the held-out one stands.
World drive_and_stops(int seed, double duration_s, int epochs) {
  Scenario s = drive_scenario(duration_s);
  s.heldout_path.kind = PathKind::kStops;
  s.heldout_path.epochs = epochs;
  s.echo_fraction = 0.02;
  return must(simulate(s, static_cast<std::uint64_t>(seed)));
}

TEST(StreamedLog, StopsAndDrivesSayWhatTheWholeSays) {
  const World world = drive_and_stops(1, 500.0, 1500);
  ASSERT_TRUE(world.heldout.has_epochs);
  EXPECT_FALSE(calib::why_not_streamed(world.site, {&world.run, &world.heldout}));
  EXPECT_TRUE(calib::is_long(must(calib::make_problem(world.site, {world.run, world.heldout}))));
  expect_same_drive(world.site, {world.run, world.heldout});
  expect_same_drive(world.site, {world.heldout, world.run});
}

// A short drive beside many stops, with noise that only the chi-square test sees.
TEST(StreamedLog, FindsTheNoiseOfStopsAndDrives) {
  const World world = drive_and_stops(2, 150.0, 4200);
  Site site = world.site;
  site.noise.tof_sigma_s *= 1.1;
  expect_same_drive(site, {world.run, world.heldout});
}

TEST(StreamedLog, RanksShareStopsAndDrives) {
  const World world = drive_and_stops(3, 400.0, 1500);
  const std::vector<MeasurementLog> runs = {world.run, world.heldout};
  const calib::Solution alone = streamed_drive(world.site, runs).solution;
  ASSERT_EQ(alone.status, calib::SolveStatus::kConverged) << alone.message;
  std::vector<calib::Solution> answers(2);
  for_each_rank(2, [&](const calib::Ranks& rank) {
    calib::SolveOptions options;
    options.ranks = &rank;
    answers[static_cast<std::size_t>(rank.index())] = streamed_drive(world.site, runs, options).solution;
  });
  for (const calib::Solution& answer : answers) {
    for (std::size_t b = 0; b < alone.state.beacon_p_map_m.size(); ++b)
      EXPECT_LT((alone.state.beacon_p_map_m[b] - answer.state.beacon_p_map_m[b]).norm(), 1e-8);
    EXPECT_EQ(answer.statistics.rejected, alone.statistics.rejected);
    EXPECT_EQ(answer.statistics.unknowns, alone.statistics.unknowns);
  }
}

}  // namespace
}  // namespace octant::test
