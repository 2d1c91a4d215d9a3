// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/clock_jumps.h"

#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace clock_jumps_test {

using calib::ClockStep;
using calib::LogHalf;
using ::testing::IsEmpty;

// One of the halves is free of the jump: by that half, it has its true size and time.
TEST(ClockJumps, AreToldByTheHalfWithoutThem) {
  for (const auto& [share, half] : {std::pair{0.3, LogHalf::kLast}, {0.7, LogHalf::kFirst}}) {
    World world = cart(80, 2);
    EXPECT_THAT(calib::clock_jumps(world.site, world.run, half), IsEmpty()) << "before";
    const double at_s = jump_clock(world, share, 4e-4);
    const std::vector<ClockStep> found = calib::clock_jumps(world.site, world.run, half);
    ASSERT_EQ(found.size(), 1U) << share;
    EXPECT_EQ(found[0].time_s, at_s);
    EXPECT_NEAR(found[0].step_s, 4e-4, 0.2e-4);
  }
}

TEST(ClockJumps, AlongADriveAreToldByTheHalfWithoutThem) {
  for (const auto& [share, half, jump_s] :
       {std::tuple{0.3, LogHalf::kLast, 2e-4}, {0.7, LogHalf::kFirst, -1e-3}, {0.5, LogHalf::kFirst, 1e-3}}) {
    World world = must(simulate(drive_scenario(), 3));
    EXPECT_THAT(calib::clock_jumps(world.site, world.run, half), IsEmpty()) << "before";
    const double at_s = jump_clock_of_drive(world, share, jump_s);
    const std::vector<ClockStep> found = calib::clock_jumps(world.site, world.run, half);
    ASSERT_EQ(found.size(), 1U) << share;
    EXPECT_NEAR(found[0].time_s, at_s, 0.5);
    EXPECT_NEAR(found[0].step_s, jump_s,
                0.2 * std::abs(jump_s));  // delays of a half bend to it
  }
}

/// A jump of metres distorts its own measurement. It is first corrected by the ranges alone, and the
/// remainder is then measured.
TEST(ClockJumps, GrossOnesAreToldInTwoSteps) {
  for (const auto& [share, half, jump_s] :
       {std::tuple{0.4, LogHalf::kLast, 2e-2}, {0.6, LogHalf::kFirst, -5e-3}}) {
    World world = must(simulate(drive_scenario(), 3));
    const double at_s = jump_clock_of_drive(world, share, jump_s);
    const std::vector<ClockStep> found = calib::clock_jumps(world.site, world.run, half);
    ASSERT_EQ(found.size(), 1U) << share;
    EXPECT_NEAR(found[0].time_s, at_s, 0.5);
    EXPECT_NEAR(found[0].step_s, jump_s, 3e-5);
  }
}

/// A jump of decimetres: the ranges alone do not show it, and its distortion causes further steps.
TEST(ClockJumps, StandAloneWhateverTheyBend) {
  for (const std::uint64_t seed : {3, 4, 5})
    for (const double jump_s : {2e-3, -1.5e-3})
      for (const LogHalf half : {LogHalf::kFirst, LogHalf::kLast}) {
        World world = must(simulate(drive_scenario(200.0), seed));
        const double at_s = jump_clock_of_drive(world, 0.5, jump_s);
        const std::vector<ClockStep> found = calib::clock_jumps(world.site, world.run, half);
        ASSERT_EQ(found.size(), 1U) << seed << ", " << jump_s;
        EXPECT_NEAR(found[0].time_s, at_s, 3.2) << "two moments of 32 arrivals, 20 a second";
        EXPECT_NEAR(found[0].step_s, jump_s, 0.1 * std::abs(jump_s));
      }
}

TEST(ClockJumps, SeveralAreToldOneAfterTheOther) {
  World world = cart(80, 2);
  const double second_s = jump_clock(world, 0.85, -6e-4), first_s = jump_clock(world, 0.6, 4e-4);
  const std::vector<ClockStep> found = calib::clock_jumps(world.site, world.run, LogHalf::kFirst);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].time_s, first_s);
  EXPECT_NEAR(found[0].step_s, 4e-4, 0.4e-4);
  EXPECT_EQ(found[1].time_s, second_s);
  EXPECT_NEAR(found[1].step_s, -6e-4, 0.4e-4);
}

TEST(ClockJumps, WhereEachEpochHasItsOwnClockThereIsNothingToSay) {
  World world = cart(40, 2);
  static_cast<void>(jump_clock(world, 0.7, 1e-3));
  world.site.timing.clock = Clock::kCycleOffset;
  EXPECT_THAT(calib::clock_jumps(world.site, world.run, LogHalf::kFirst), IsEmpty());
}

TEST(ClockJumps, TakenBackLeaveTheTimesThatTheFirstClockWouldHaveSeen) {
  MeasurementLog run;
  for (const double time_s : {1.0, 2.0, 3.0, 4.0}) {
    Arrival a;
    a.time_s = time_s;
    a.tof_s = 0.010;
    run.arrivals.push_back(a);
  }
  calib::without_jumps({{2.0, 0.001, 3}, {4.0, -0.003, 3}}, run);
  const double tofs[] = {0.010, 0.009, 0.009, 0.012};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(run.arrivals[i].tof_s, tofs[i], 1e-15) << i;
}

}  // namespace clock_jumps_test
}  // namespace octant::test
